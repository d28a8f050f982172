// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <unistd.h>

#include <apps/interruption.hpp>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <system_error>
#include <thread>

namespace mapjoin::apps {
namespace {

/// A handler may do little more than write a byte: a thread at the other end of this pipe does the rest.
int signal_pipe[2] = {-1, -1};
std::atomic<bool> signal_has_come = false;
static_assert(std::atomic<bool>::is_always_lock_free);
constexpr std::chrono::milliseconds kAgainAfter(50);

extern "C" void on_signal(int) {
  const int errno_before = errno;
  signal_has_come = true;
  const char byte = 0;
  [[maybe_unused]] const auto written = ::write(signal_pipe[1], &byte, 1);
  errno = errno_before;
}

}  // namespace

bool Interruption::has_come() const {
  return signal_has_come;
}

Interruption::Interruption() {
  std::signal(SIGPIPE, SIG_IGN);
  if (::pipe2(signal_pipe, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe2");
  std::thread([source = source_, main = ::pthread_self()]() mutable {
    char byte = 0;
    while (true) {
      if (::read(signal_pipe[0], &byte, 1) != 1) continue;
      source.request_stop();
      // The signal may have come just before a call that waits for ever, or in the midst of a write: it comes again.
      std::this_thread::sleep_for(kAgainAfter);
      ::pthread_kill(main, SIGINT);
    }
  }).detach();
  struct sigaction action {};
  action.sa_handler = on_signal;  // Without SA_RESTART: a read or write that waits ends too.
  for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
}

}  // namespace mapjoin::apps
