// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <apps/process.hpp>
#include <chrono>
#include <csignal>
#include <iostream>
#include <thread>

namespace mapjoin::apps {
namespace {

/// A process that is deaf to the request to stop.
[[noreturn]] void go_on_whatever_is_asked(int first, int second) {
  ::alarm(60);
  keep_blas_on_one_thread();
  const Interruption interruption;
  ::kill(::getpid(), first);
  while (!interruption.token().stop_requested()) std::this_thread::yield();
  ::kill(::getpid(), second);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::cerr << "both at once were one request";
  ::kill(::getpid(), second);
  while (true) ::pause();
}

TEST(InterruptionDeathTest, TheSecondSignalEndsTheProcessWhateverItDoes) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(go_on_whatever_is_asked(SIGTERM, SIGTERM), ::testing::ExitedWithCode(130), "were one request");
  EXPECT_EXIT(go_on_whatever_is_asked(SIGINT, SIGTERM), ::testing::ExitedWithCode(130), "were one request");
}

}  // namespace
}  // namespace mapjoin::apps
