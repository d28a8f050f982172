// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/frames/name_fit.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin::testing {
namespace {

TEST(NameFit, IsGoodWhereSessionsSeeTheSameFeatures) {
  const auto world = small_world<2>({.sessions = 2});
  const auto fit = worst_name_fit(world.log, 0.99).value();
  ASSERT_TRUE(fit);
  EXPECT_GE(fit->features, 5U);
  EXPECT_GT(fit->alike, 0.9);
  EXPECT_EQ(fit->second, (PoseId{1, 0}));
}

TEST(NameFit, IsBadWhereNamesMeanOtherFeatures) {
  auto log = small_world<2>({.sessions = 2}).log;
  const auto features = static_cast<std::int32_t>(log.features.size());
  for (auto& seen : log.graph.feature_factors) {
    if (log.poses[seen.base].session == 1) seen.target = FeatureIndex((seen.target.value * 7 + 3) % features);
  }
  EXPECT_LT(worst_name_fit(log, 0.99).value()->alike, 0.5);
}

TEST(NameFit, IsOfNothingWhereNoNamesTie) {
  EXPECT_FALSE(worst_name_fit(small_world<2>().log, 0.99).value());
}

}  // namespace
}  // namespace mapjoin::testing
