// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/solve/memory_limit.hpp>

namespace mapjoin {
namespace {

TEST(MemoryLimit, IsRefusedBeyondTheLimitInASentence) {
  EXPECT_TRUE(check_memory("the covariances", 1000, 1000));
  EXPECT_TRUE(check_memory("the covariances", 1000, 0));
  const auto refused = check_memory("the covariances", 3'000'000, 2'000'000);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kTooLarge);
  EXPECT_EQ(refused.error().message, "the covariances would take 3 MB of memory, more than the 2 MB allowed");
  EXPECT_EQ(check_memory("they", 12'345'678, 1200).error().message,
            "they would take 12.3 MB of memory, more than the 0.0012 MB allowed");
  EXPECT_FALSE(check_memory("the covariances", machine_memory() + 1, 0));
}

}  // namespace
}  // namespace mapjoin
