// SPDX-License-Identifier: BSD-3-Clause
#include <pthread.h>

#include <apps/interruption.hpp>
#include <chrono>
#include <csignal>
#include <thread>

namespace mapjoin::apps {
namespace {

/// Ends the main thread's reads and writes that wait.
constexpr int kWakes = SIGUSR1;
constexpr std::chrono::milliseconds kAgainAfter(50);

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
    int signal = 0;
    while (::sigwait(&signals, &signal) != 0) {
    }
    source.request_stop();
    while (true) {  // It may come just before a call that waits for ever.
      ::pthread_kill(main, kWakes);
      std::this_thread::sleep_for(kAgainAfter);
    }
  }).detach();
}

}  // namespace mapjoin::apps
