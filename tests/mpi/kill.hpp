// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Calls of `mpirun` one of whose ranks is killed.

#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <tests/mpi/mpi_command.hpp>
#include <thread>
#include <vector>

namespace mapjoin::testing {

/// The children of a process.
inline std::vector<::pid_t> children_of(::pid_t parent) {
  std::vector<::pid_t> children;
  std::error_code gone;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(parent) + "/task", gone)) {
    std::ifstream list(thread.path() / "children");
    for (::pid_t child; list >> child;) children.push_back(child);
  }
  return children;
}

/// True if a process runs; one that has ended and that nobody has waited for does not.
inline bool is_running(::pid_t process) {
  return !content_of("/proc/" + std::to_string(process) + "/cmdline").empty();
}

inline void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// The exit code of an `mpirun` whose ranks have ended. If one was killed, mpirun may wait for ever in PMIx_server_finalize()
/// (PMIx 4.2), for a lock within its own process: after ten seconds it is killed, too.
inline int exit_code_after_ranks(Process& mpirun) {
  for (int tenths = 0; tenths < 100 && mpirun.is_running(); ++tenths) sleep_for(0.1);
  if (mpirun.is_running()) mpirun.send(SIGKILL);
  return mpirun.wait();
}

/// Calls two ranks, kills one of them once `wait`, which can ask whether the call is over, returns, and waits until none runs.
/// Returns true if the call was done before.
inline bool kill_one_of_two(const std::vector<std::string>& arguments, std::size_t victim,
                            const std::function<void(const std::function<bool()>& is_over)>& wait) {
  Process process(mpi_command_line(2, arguments));
  std::vector<::pid_t> ranks;
  while (ranks.size() < 2 && process.is_running()) ranks = children_of(process.id());
  if (ranks.size() != 2) throw std::runtime_error("two ranks were called, and " + std::to_string(ranks.size()) + " started");
  wait([&] { return !process.is_running(); });
  if (process.is_running()) ::kill(ranks[victim], SIGKILL);
  while (is_running(ranks.front()) || is_running(ranks.back())) sleep_for(0.01);
  return exit_code_after_ranks(process) == 0;
}

}  // namespace mapjoin::testing
