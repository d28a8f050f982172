// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/frames/name_fit.hpp>
#include <tests/support/small_submap_set.hpp>
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

TEST(NameFit, IsThatOfTheTwoSessionsThatFitWorst) {
  auto log = small_world<2>({.sessions = 3}).log;
  const auto features = static_cast<std::int32_t>(log.features.size());
  for (auto& seen : log.graph.feature_factors) {
    if (log.poses[seen.base].session == 1) seen.target = FeatureIndex((seen.target.value * 7 + 3) % features);
  }
  const auto fit = worst_name_fit(log, 0.99).value().value();
  EXPECT_LT(fit.alike, 0.5);
  EXPECT_TRUE(fit.first.session == 1 || fit.second.session == 1);
}

TEST(NameFit, IsBadWhereASessionIsOfAnotherScale) {
  auto log = small_world<2>({.sessions = 2}).log;
  const auto scaled = [&](PoseIndex pose) { return log.poses[pose].session == 1 ? 1.03 : 1.0; };
  for (auto& step : log.graph.pose_factors) step.measured.translation *= scaled(step.base);
  for (auto& seen : log.graph.feature_factors) seen.measured *= scaled(seen.base);
  EXPECT_LT(worst_name_fit(log, 0.99).value()->alike, 0.5);
}

/// One wrong observation bends the map of its session; ids still mean the same features.
TEST(NameFit, IsGoodWhereOneWrongObservationBendsAMap) {
  auto log = small_world<2>({.features = 40, .closures = 0, .sessions = 2, .range = 3.0}).log;
  FeatureFactor<2>& seen = log.graph.feature_factors[log.observations().size() / 4];
  ASSERT_EQ(log.poses[seen.base].session, 0U);
  seen.target = FeatureIndex((seen.target.value + 20) % 40);
  seen.information *= 1e4;
  EXPECT_TRUE(worst_name_fit(log, 0.99).value()->is_good());
}

/// Half of forty ids mean other features, so that a little less than a quarter of all distances is between two right ones.
TEST(NameFit, IsTheShareOfAllDistances) {
  auto log = small_world<2>({.features = 40, .sessions = 2, .range = 30.0}).log;
  for (auto& seen : log.graph.feature_factors) {
    const std::int32_t name = seen.target.value;
    if (log.poses[seen.base].session == 1 && name < 20) seen.target = FeatureIndex((name + 7) % 20);
  }
  const auto fit = worst_name_fit(log, 0.99).value().value();
  EXPECT_EQ(fit.features, 40U);
  EXPECT_GT(fit.alike, 0.2);
  EXPECT_LT(fit.alike, 0.4);
}

TEST(NameFit, PriorsOfFeaturesDoNotCount) {
  auto log = small_world<2>({.sessions = 2}).log;
  const auto alike = worst_name_fit(log, 0.99).value()->alike;
  for (FeatureIndex f = 0; f < 3; ++f) {
    log.graph.feature_factors.push_back({kWorld, f, Point<2>(1000.0 * f.value, 0.0), 1e6 * PointMatrix<2>::Identity()});
  }
  EXPECT_EQ(worst_name_fit(log, 0.99).value()->alike, alike);
  auto set = small_submap_set(small_world<2>().log, 10.0);
  set.graph.feature_factors.push_back({kWorld, 0, Point<2>::Zero(), PointMatrix<2>::Identity()});
  EXPECT_FALSE(worst_name_fit(set, 0.99).value());
}

TEST(NameFit, IsOfNothingWhereNoNamesTie) {
  EXPECT_FALSE(worst_name_fit(small_world<2>().log, 0.99).value());
}

}  // namespace
}  // namespace mapjoin::testing
