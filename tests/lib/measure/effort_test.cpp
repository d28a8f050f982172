// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstring>
#include <ctime>
#include <mapjoin/measure/effort.hpp>
#include <thread>
#include <vector>

namespace mapjoin::testing {
namespace {

constexpr std::size_t kBytes = 64'000'000;

/// Memory that was written to, so that the system has provided it.
std::vector<char> written() {
  std::vector<char> bytes(kBytes);
  std::memset(bytes.data(), 1, bytes.size());
  return bytes;
}

/// The CPU time of the calling thread (s).
double cpu_seconds_here() {
  ::timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

TEST(Effort, CountsTheTimeOfTheWallAndThatOfAllThreads) {
  const EffortMeter meter;
  {
    const auto work = [] {
      while (cpu_seconds_here() < 0.1) continue;
    };
    const std::jthread one(work);
    const std::jthread two(work);
  }
  const Effort effort = meter.so_far();
  EXPECT_GE(effort.seconds, 0.1);
  EXPECT_GE(effort.cpu_seconds, 0.19);
}

TEST(Effort, CountsTheLargestMemoryEvenWhereItIsGivenBack) {
  const EffortMeter meter;
  if (!meter.so_far().memory) GTEST_SKIP() << "The system does not tell.";
  EXPECT_LT(*meter.so_far().memory, static_cast<std::int64_t>(kBytes) / 2);
  EXPECT_EQ(written().back(), 1);
  EXPECT_GT(*meter.so_far().memory, static_cast<std::int64_t>(kBytes) * 9 / 10);
}

TEST(Effort, ForgetsTheMemoryOfEarlierWork) {
  EXPECT_EQ(written().back(), 1);
  const EffortMeter meter;
  if (!meter.so_far().memory) GTEST_SKIP() << "The system does not tell.";
  EXPECT_LT(*meter.so_far().memory, static_cast<std::int64_t>(kBytes) / 2);
}

}  // namespace
}  // namespace mapjoin::testing
