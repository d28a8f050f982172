// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <unistd.h>

#include <apps/interruption.hpp>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <thread>

namespace mapjoin::apps {
namespace {

/// A handler may do little more than write a byte: a thread at the other end of this pipe does the rest.
int signal_pipe[2] = {-1, -1};

extern "C" void on_signal(int) {
  const int errno_before = errno;
  const char byte = 0;
  [[maybe_unused]] const auto written = ::write(signal_pipe[1], &byte, 1);
  errno = errno_before;
}

}  // namespace

Interruption::Interruption() {
  std::signal(SIGPIPE, SIG_IGN);
  if (::pipe2(signal_pipe, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe2");
  std::thread([source = source_]() mutable {
    char byte = 0;
    while (::read(signal_pipe[0], &byte, 1) < 0 && errno == EINTR) {
    }
    source.request_stop();
  }).detach();
  struct sigaction action {};
  action.sa_handler = on_signal;  // Without SA_RESTART: a read that waits for ever ends too.
  for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
}

}  // namespace mapjoin::apps
