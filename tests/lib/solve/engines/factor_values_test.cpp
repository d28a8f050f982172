// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/solve/engines/factor_values.hpp>
#include <string>
#include <system_error>

namespace mapjoin {
namespace {

TEST(FactorValues, SayForHowMuchThereIsNoRoom) {
  for (const auto& [count, size] : {std::pair<std::size_t, const char*>{100, "0.0008 MB"}, {5'000'000, "40.0 MB"}}) {
    std::string told;
    try {
      const FactorValues values(count, "/proc");
    } catch (const std::system_error& failure) {
      told = failure.what();
    }
    EXPECT_THAT(told, ::testing::StartsWith(std::string("/proc: no room for a file of ") + size + ": "));
  }
}

}  // namespace
}  // namespace mapjoin
