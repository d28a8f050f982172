// SPDX-License-Identifier: BSD-3-Clause
// Sessions in unknown frames: aligned by their features, left apart if these do not determine how.
#include <gtest/gtest.h>

#include <map>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/support/cut_log.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/wood.hpp>

namespace mapjoin::testing {
namespace {

template <typename D>
class UnknownFramesTest : public ::testing::Test {};
TYPED_TEST_SUITE(UnknownFramesTest, Dimensions);

TYPED_TEST(UnknownFramesTest, AreFoundAsPreciselyAsTheirCovarianceSays) {
  constexpr int kDim = TypeParam::value;
  RunOptions options;
  options.covariances = true;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto world = wood<kDim>(seed);
    AssociationOptions own;
    own.names_hold = true;
    const auto found = associate(in_two_sessions(world.log), own).value();
    ASSERT_TRUE(found.untied.empty()) << seed;
    const auto joined = run(found.data, options).value();
    const PoseIndex second = session_of(world.log, 1, 2).first;
    const Pose<kDim> estimate = between(joined.map.poses[PoseIndex(0)], joined.map.poses[second]);
    const Pose<kDim> truth = between(world.truth.poses[PoseIndex(0)], world.truth.poses[second]);
    PoseVector<kDim> error;
    error << truth.translation - estimate.translation, (estimate.rotation.inverse() * truth.rotation).log();
    const auto covariance = joined.covariances->relative_pose(PoseIndex(0), second).value();
    EXPECT_LT(error.dot(covariance.llt().solve(error)), chi_squared_quantile(0.999, kPoseDof<kDim>)) << seed;
  }
}

TYPED_TEST(UnknownFramesTest, AreFoundWhereNoFeatureHasAName) {
  const auto found = associate(in_two_sessions(wood<TypeParam::value>(7).log), AssociationOptions{}).value();
  EXPECT_TRUE(found.untied.empty());
}

TEST(UnknownFrames, LeaveNamesOfOneSessionApart) {
  const Log<2> log = in_two_sessions(wood<2>(3).log);
  AssociationOptions own;
  own.names_hold = true;
  const auto found = associate(log, own).value();
  std::map<std::pair<std::uint32_t, FeatureId>, FeatureId> joined;
  std::map<std::pair<std::uint32_t, FeatureId>, FeatureId> named;
  for (const AssociatedSighting& s : found.sightings) {
    EXPECT_EQ(joined.emplace(std::pair(s.base.session, s.name), s.joined).first->second, s.joined);
    EXPECT_EQ(named.emplace(std::pair(s.base.session, s.joined), s.name).first->second, s.name);
  }
  EXPECT_LT(found.data.features.size(), log.features.size());
}

TEST(UnknownFrames, OfOtherWorldsStayApart) {
  std::vector<Log<2>> logs = {wood<2>(1).log, wood<2>(2).log};
  for (const bool names_hold : {false, true}) {
    AssociationOptions options;
    options.names_hold = names_hold;
    const auto found = associate(merged(logs, {.own_features = true}).value(), options).value();
    ASSERT_EQ(found.untied.size(), 1U);
    EXPECT_EQ(found.untied.front().first, (PoseId{0, 0}));
    EXPECT_EQ(found.untied.front().second, (PoseId{1, 0}));
    EXPECT_EQ(found.untied.front().alignment.status, AlignmentStatus::kNone);
  }
}

TEST(UnknownFrames, OfARegularPlantationStayApart) {
  ManhattanOptions options;
  options.poses = 200;
  options.side = 15.0;
  options.range = 5.0;
  options.feature_cell = 2.5;
  options.feature_jitter = 0.0;
  AssociationOptions own;
  own.names_hold = true;
  const auto found = associate(in_two_sessions(simulate_manhattan<2>(options).log), own).value();
  ASSERT_EQ(found.untied.size(), 1U);
  EXPECT_EQ(found.untied.front().alignment.status, AlignmentStatus::kAmbiguous);
}

}  // namespace
}  // namespace mapjoin::testing
