// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/join/association/matching/sighting_chance.hpp>

namespace mapjoin {
namespace {

TEST(SightingChance, IsTheShareThatWasSeenFromSoFarAway) {
  std::vector<SightingTrial> trials;
  for (int k = 0; k < 4000; ++k) trials.emplace_back(0.005 * k, k < 2000 || (k < 3000 && k % 4 == 0));
  const SightingChance chance(trials);
  EXPECT_NEAR(chance(3.0), 1.0, 0.01);
  EXPECT_NEAR(chance(12.0), 0.25, 0.01);
  EXPECT_NEAR(chance(18.0), 0.0, 0.01);
  EXPECT_LT(chance(3.0), 1.0) << "never quite certain";
}

TEST(SightingChance, IsThatOfNotBeingOverlooked) {
  std::vector<SightingTrial> trials;  // nothing is seen from nearer than 5 m, or farther than 15 m
  for (int k = 0; k < 4000; ++k) trials.emplace_back(0.005 * k, k >= 1000 && k < 3000);
  const SightingChance chance(trials);
  EXPECT_DOUBLE_EQ(std::exp(chance.log_overlooked(10.0, 0.0)), 1.0 - chance(10.0));
  EXPECT_LT(chance.log_overlooked(10.0, 3.0), -3.0);
  for (const double distance : {6.0, 14.0}) EXPECT_GT(chance.log_overlooked(distance, 3.0), -0.1) << distance;
  EXPECT_EQ(chance.log_overlooked(19.0, 2.0), 0.0) << "beyond what was tried";
}

TEST(SightingChance, IsNoneBeyondWhatWasTried) {
  EXPECT_EQ(SightingChance({{1.0, true}, {2.0, true}})(2.5), 0.0);
  EXPECT_EQ(SightingChance()(1.0), 0.0);
}

}  // namespace
}  // namespace mapjoin
