// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <tests/apps/command.hpp>
#include <tests/mpi/mpi_command.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

/// The processes that a process has started.
std::vector<::pid_t> children_of(::pid_t parent) {
  std::vector<::pid_t> children;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(parent) + "/task")) {
    std::ifstream list(thread.path() / "children");
    for (::pid_t child; list >> child;) children.push_back(child);
  }
  return children;
}

/// Whether a process runs; one that nobody has asked for its exit code does not.
bool is_running(::pid_t process) {
  return !content_of("/proc/" + std::to_string(process) + "/cmdline").empty();
}

TEST(KilledRank, EndsAllAndLeavesNoHalfOfAMap) {
  const TemporaryFolder folder;
  const std::string log = (folder.path() / "log.g2o").string();
  const std::filesystem::path map = folder.path() / "map.g2o";
  ASSERT_EQ(call({"simulate", "--poses", "20000", "-o", log, "--quiet"}).exit_code, 0);
  for (const int milliseconds : {0, 50, 150, 300, 500}) {
    Process process(mpi_command_line(2, {"run", log, "-o", map.string()}));
    std::vector<::pid_t> ranks;
    while (ranks.size() < 2 && process.is_running()) ranks = children_of(process.id());
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ASSERT_EQ(ranks.size(), 2U);
    ::kill(ranks.back(), SIGKILL);
    const bool was_done = process.wait() == 0;
    EXPECT_EQ(std::filesystem::exists(map), was_done) << milliseconds;
    while (is_running(ranks.front()) || is_running(ranks.back())) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    std::filesystem::remove(map);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << milliseconds;
  }
}

}  // namespace
}  // namespace mapjoin::testing
