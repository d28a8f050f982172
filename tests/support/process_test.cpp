// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <csignal>
#include <tests/support/process.hpp>

namespace mapjoin::testing {
namespace {

double user_seconds(const Process& process) {
  const ::timeval& time = process.usage().ru_utime;
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

TEST(Process, EndsOneThatTakesMoreTimeThanItMay) {
  ProcessOptions options;
  options.cpu_seconds = 1;
  Process process({"sh", "-c", "while :; do :; done"}, options);
  EXPECT_EQ(process.wait(), 1000 + SIGXCPU);
  EXPECT_GT(user_seconds(process), 0.5);
}

TEST(Process, KnowsWhatAProgramTookAndSaid) {
  Process process({"sh", "-c", "echo words; exit 7"});
  EXPECT_EQ(process.wait(), 7);
  EXPECT_EQ(process.standard_output(), "words\n");
  EXPECT_GT(process.usage().ru_maxrss, 0);
}

}  // namespace
}  // namespace mapjoin::testing
