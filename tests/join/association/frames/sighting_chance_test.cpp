// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/frames/sighting_chance.hpp>

namespace mapjoin {
namespace {

TEST(SightingChance, IsTheShareThatWasSeenFromSoFarAway) {
  std::vector<std::pair<double, bool>> trials;
  for (int k = 0; k < 4000; ++k) trials.emplace_back(0.005 * k, k < 2000 || (k < 3000 && k % 4 == 0));
  const SightingChance chance(trials);
  EXPECT_NEAR(chance(3.0), 1.0, 0.01);
  EXPECT_NEAR(chance(12.0), 0.25, 0.01);
  EXPECT_NEAR(chance(18.0), 0.0, 0.01);
  EXPECT_LT(chance(3.0), 1.0) << "never quite certain";
}

TEST(SightingChance, IsNoneBeyondWhatWasTried) {
  EXPECT_EQ(SightingChance({{1.0, true}, {2.0, true}})(2.5), 0.0);
  EXPECT_EQ(SightingChance({})(1.0), 0.0);
}

}  // namespace
}  // namespace mapjoin
