// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>
#include <tests/support/process.hpp>

namespace mapjoin::testing {
namespace {

/// Opens `path` for writing, and returns its descriptor.
int open_output(const std::filesystem::path& path) {
  return ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
}

/// Sets this process's soft limit of a resource to `most`, and its hard limit to `most` + `more`; no limits if `most` is 0.
void limit(__rlimit_resource resource, std::size_t most, std::size_t more = 0) {
  const ::rlimit both{most, most + more};
  if (most > 0) ::setrlimit(resource, &both);
}

int pipe_without_reader() {
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
  ::close(ends[0]);
  return ends[1];
}

}  // namespace

Process::Process(const std::vector<std::string>& words, const ProcessOptions& options) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const int out = options.reader_has_gone           ? pipe_without_reader()
                  : options.standard_output.empty() ? open_output(folder_.path() / "out")
                                                    : open_output(options.standard_output);
  const int err = open_output(folder_.path() / "err");
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("fork");
  if (pid_ == 0) {
    ::dup2(out, STDOUT_FILENO);
    ::dup2(err, STDERR_FILENO);
    if (!options.working_folder.empty() && ::chdir(options.working_folder.c_str()) != 0) ::_exit(127);
    limit(RLIMIT_DATA, options.memory_bytes);
    limit(RLIMIT_AS, options.address_space_bytes);
    limit(RLIMIT_CPU, options.cpu_seconds, 1);
    ::execvp(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(out);
  ::close(err);
}

Process::~Process() {
  if (exit_code_ >= 0) return;
  ::kill(pid_, SIGKILL);
  wait();
}

void Process::send(int signal) const {
  if (exit_code_ < 0) ::kill(pid_, signal);
}

bool Process::is_running() {
  int status = 0;
  if (exit_code_ < 0 && ::wait4(pid_, &status, WNOHANG, &usage_) == pid_) note_end(status);
  return exit_code_ < 0;
}

int Process::wait() {
  int status = 0;
  if (exit_code_ < 0 && ::wait4(pid_, &status, 0, &usage_) == pid_) note_end(status);
  return exit_code_;
}

void Process::note_end(int status) {
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

}  // namespace mapjoin::testing
