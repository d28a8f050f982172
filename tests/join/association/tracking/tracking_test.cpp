// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/tracking/feature_filter.hpp>
#include <mapjoin/join/association/tracking/tracking.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class FeatureFilterTest : public ::testing::Test {};
TYPED_TEST_SUITE(FeatureFilterTest, testing::Dimensions);

TYPED_TEST(FeatureFilterTest, FollowsFeaturesInTheFrameOfTheRobot) {
  constexpr int kDim = TypeParam::value;
  testing::Random random(3);
  const Pose<kDim> step = random.pose<kDim>(1.0, 0.4);
  const Point<kDim> p = random.vector<kDim>(3.0);
  const PoseMatrix<kDim> W = 100.0 * random.information<kPoseDof<kDim>>();
  const FeatureFactor<kDim> seen{0, 0, p, 1e4 * PointMatrix<kDim>::Identity()};
  FeatureFilter<kDim> forward;
  forward.add(seen);
  forward.move({0, 1, step, W});
  EXPECT_LT((forward.features()[0] - transform_into<kDim>(step, p)).norm(), 1e-12);

  // The step stored against its direction, with its information to first order.
  PoseMatrix<kDim> J;
  const Pose<kDim> back = inverse(step, &J);
  const PoseMatrix<kDim> J_inverse = J.inverse();
  FeatureFilter<kDim> backward;
  backward.add(seen);
  backward.move({1, 0, back, J_inverse.transpose() * W * J_inverse});
  EXPECT_LT((backward.features()[0] - forward.features()[0]).norm(), 1e-12);
  EXPECT_LT((backward.covariance() - forward.covariance()).norm(), 1e-7 * forward.covariance().norm());
}

TYPED_TEST(FeatureFilterTest, LearnsOfAllFeaturesByOne) {
  constexpr int kDim = TypeParam::value;
  FeatureFilter<kDim> filter;
  const PointMatrix<kDim> precise = 1e6 * PointMatrix<kDim>::Identity();
  const Point<kDim> p = Point<kDim>::Constant(1.0);
  filter.add({0, 0, p, precise});
  filter.add({0, 1, 1.1 * p, precise});
  PoseMatrix<kDim> W = PoseMatrix<kDim>::Identity();
  W.template bottomRightCorner<kRotationDof<kDim>, kRotationDof<kDim>>() *= 1e9;  // the robot does not turn
  filter.move({0, 1, {}, W});
  const double before = filter.covariance().trace();
  const Point<kDim> shift = Point<kDim>::Constant(0.3);
  filter.update(0, {1, 0, p + shift, precise});
  EXPECT_LT(filter.covariance().trace(), 1e-3 * before);
  EXPECT_LT((filter.features()[1] - (1.1 * p + shift)).norm(), 1e-3);
}

/// The tracks of a log whose poses stand still. Observations have this standard deviation (m); odometry is some thirty times as
/// certain.
Tracks<2> tracks_of(const std::vector<std::vector<Point<2>>>& scans, double deviation, const SightingChance& sees = {}) {
  LogBuilder<2> builder("standing");
  const double w = 1.0 / (deviation * deviation);
  std::uint64_t name = 0;
  for (std::uint64_t pose = 0; pose < scans.size(); ++pose) {
    builder.add_pose({0, pose});
    if (pose > 0) builder.add_pose_edge({0, pose - 1}, {0, pose}, {}, 1e3 * w * PoseMatrix<2>::Identity());
    for (const auto& p : scans[pose]) builder.add_observation({0, pose}, {name++}, p, w * PointMatrix<2>::Identity());
  }
  const Log<2> log = std::move(builder).finish().value();
  const NeighbourDensity<2> density(scans);
  Matcher<2> matcher(density, AssociationMethod::kJcbb, 0.99, 10.0);
  Split parts = split(log, {SplitRule::kPoses, 100.0});
  return track(segment_view(log, parts, parts.segments[0]), sees, matcher, 0.99);
}

/// The label of each observation of tracks_of().
std::vector<std::size_t> labels_of(const std::vector<std::vector<Point<2>>>& scans, double deviation,
                                   const SightingChance& sees = {}) {
  std::vector<std::size_t> labels;
  for (const Tracked& tracked : tracks_of(scans, deviation, sees).observations) labels.push_back(tracked.feature);
  return labels;
}

const std::vector<Point<2>> kTrees = {{3.0, 0.0}, {6.0, 2.0}, {4.0, -5.0}, {8.0, 4.0}};

TEST(TrackTest, StartsATentativeFeatureWhereNoneWasAndGoesOnWithIt) {
  const auto labels = labels_of({kTrees, {{3.0, 0.02}, {15.0, 15.0}}, {{15.02, 15.0}, {6.0, 2.01}}}, 0.05);
  EXPECT_EQ(labels, (std::vector<std::size_t>{0, 1, 2, 3, 0, 4, 4, 1}));
}

TEST(TrackTest, SetsAsideWhatCouldBeEitherAndGoesOnWithBoth) {
  auto trees = kTrees;
  trees.emplace_back(3.4, 0.0);
  // A tree between the first and the last could be either, and becomes a feature of its own, which misleads nothing after it.
  const auto labels = labels_of({trees, {{3.2, 0.0}}, {{3.0, 0.0}, {3.4, 0.0}}}, 0.07);
  EXPECT_EQ(labels, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 0, 4}));
}

TEST(TrackTest, TellsWhichFeaturesWereSeenAgainAndFromHowFar) {
  const auto tracks = tracks_of({kTrees, {}, {{3.0, 0.02}}}, 0.05);
  ASSERT_EQ(tracks.trials.size(), kTrees.size()) << "a pose that sees nothing tells nothing";
  for (std::size_t k = 0; k < kTrees.size(); ++k) {
    EXPECT_NEAR(tracks.trials[k].first, kTrees[k].norm(), 1e-9);
    EXPECT_EQ(tracks.trials[k].second, k == 0);
  }
  ASSERT_EQ(tracks.followed.size(), 1u);
  EXPECT_NEAR((tracks.followed[0] - Point<2>(3.0, 0.01)).norm(), 0.0, 1e-3);
}

TEST(TrackTest, TakesWhatWouldHardlyHaveBeenOverlookedForSeenAgain) {
  const std::vector<std::vector<Point<2>>> scans = {kTrees, {{3.0, 0.21}, kTrees[1], kTrees[2]}};  // three standard deviations
  EXPECT_EQ(labels_of(scans, 0.05)[kTrees.size()], kTrees.size()) << "set aside";
  std::vector<SightingTrial> trials;
  for (int k = 0; k < 4000; ++k) trials.emplace_back(0.005 * k, true);
  EXPECT_EQ(labels_of(scans, 0.05, SightingChance(trials))[kTrees.size()], 0u);
}

}  // namespace
}  // namespace mapjoin
