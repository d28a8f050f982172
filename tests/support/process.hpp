// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Programs run as a user's shell runs them, with their output kept.

#include <sys/resource.h>
#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <iterator>
#include <string>
#include <tests/support/temporary_folder.hpp>
#include <vector>

namespace mapjoin::testing {

/// Streams, folder and limits of a program.
struct ProcessOptions {
  std::filesystem::path working_folder;   ///< Empty: that of the test.
  std::filesystem::path standard_output;  ///< File for standard output; empty: it is kept.
  bool reader_has_gone = false;           ///< Standard output is a pipe without a reader.
  std::size_t memory_bytes = 0;           ///< Limit of its data (RLIMIT_DATA); 0: no limit.
  std::size_t cpu_seconds = 0;            ///< CPU time after which SIGXCPU ends it; 0: no limit.
  std::size_t address_space_bytes = 0;    ///< Limit of its address space (RLIMIT_AS); 0: no limit.
};

class Process {
 public:
  /// Starts `words[0]`, found on the PATH, with the rest as arguments.
  explicit Process(const std::vector<std::string>& words, const ProcessOptions& options = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  ::pid_t id() const { return pid_; }
  void send(int signal) const;
  bool is_running();
  /// Waits for its end, and returns the exit code, or 1000 plus the number of the signal that killed it.
  int wait();
  /// The resources it used and its output, once it has ended.
  const ::rusage& usage() const { return usage_; }
  std::string standard_output() const { return content_of(folder_.path() / "out"); }
  std::string standard_error() const { return content_of(folder_.path() / "err"); }

 private:
  void note_end(int status);

  TemporaryFolder folder_;
  ::pid_t pid_ = -1;
  int exit_code_ = -1;
  ::rusage usage_{};
};

/// The number of threads of the process with this id, whoever started them; "self": of this process.
inline std::ptrdiff_t threads_of(const std::string& process) {
  return std::distance(std::filesystem::directory_iterator("/proc/" + process + "/task"), {});
}

}  // namespace mapjoin::testing
