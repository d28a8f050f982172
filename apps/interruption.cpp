// SPDX-License-Identifier: BSD-3-Clause
#include <pthread.h>

#include <apps/exit_code.hpp>
#include <apps/interruption.hpp>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <thread>

namespace mapjoin::apps {
namespace {

/// Ends the main thread's reads and writes that wait.
constexpr int kWakes = SIGUSR1;
constexpr ::timespec kAgainAfter{0, 50'000'000};

}  // namespace

Interruption::Interruption() {
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
  struct sigaction waking {};
  waking.sa_handler = [](int) {};  // Without SA_RESTART.
  ::sigaction(kWakes, &waking, nullptr);

  // Blocked in this thread and in all that it starts, and waited for in one: handlers would not do, for METIS puts its own in
  // their place while it works, and takes SIGTERM for an error.
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM}) ::sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals, source = source_, main = ::pthread_self()]() mutable {
    while (::sigwaitinfo(&signals, nullptr) < 0) {
    }
    source.request_stop();
    do {  // It may come just before a call that waits for ever.
      ::pthread_kill(main, kWakes);
    } while (::sigtimedwait(&signals, nullptr, &kAgainAfter) < 0);
    std::_Exit(static_cast<int>(ExitCode::kInterrupted));
  }).detach();
}

}  // namespace mapjoin::apps
