// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <deque>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/every.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::full_slam;
using testing::largest_difference;
using testing::small_world;
using testing::SmallWorld;

/// Logs whose frame is given by fixed poses and priors, with the truth away from the origin.
template <typename D>
class WorldTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;
  static constexpr int kRot = kRotationDof<kDim>;

  void place(SmallWorld<kDim> small) {
    world = std::move(small);
    world.truth = moved(random.pose<kDim>(100.0, 3.0), world.truth);
  }
  void SetUp() override { place(small_world<kDim>()); }

  PoseFactor<kDim> prior(PoseIndex pose) {
    return {kWorld, pose, retract(world.truth.pose(pose), PoseVector<kDim>(random.vector<kDof>(0.02))),
            1e3 * random.information<kDof>()};
  }
  /// A prior of a position without information on the rotation, as of GPS.
  PoseFactor<kDim> gps(PoseIndex pose) {
    auto position = prior(pose);
    position.information.template rightCols<kRot>().setZero();
    position.information.template bottomRows<kRot>().setZero();
    return position;
  }
  FeatureFactor<kDim> feature_prior(FeatureIndex feature) {
    return {kWorld, feature, world.truth.features[feature] + random.vector<kDim>(0.02), 1e3 * random.information<kDim>()};
  }
  void expect_optimum(const std::vector<PoseIndex>& gauge) {
    Values<kDim> start = world.truth;
    for (const auto& fixed : world.log.graph.fixed) start.poses[fixed.pose] = fixed.value;
    const Values<kDim> optimum = full_slam(world.log).optimum(std::move(start));
    for (const auto schedule : testing::every<Schedule>()) {
      RunOptions options;
      options.split = {SplitRule::kPoses, 6.0};
      options.schedule = schedule;
      const auto result = run(world.log, options);
      ASSERT_TRUE(result) << result.error().message;
      EXPECT_TRUE(result->converged());
      EXPECT_EQ(result->map.gauge, gauge);
      EXPECT_LT(largest_difference(Values<kDim>{result->map.poses, result->map.features}, optimum), 1e-5);
    }
  }

  testing::Random random{11};
  SmallWorld<kDim> world;
};
TYPED_TEST_SUITE(WorldTest, testing::Dimensions);

TYPED_TEST(WorldTest, AFixedPoseHoldsTheMap) {
  this->world.log.graph.fixed = {{17, this->world.truth.pose(17)}};
  this->expect_optimum({17});
}

TYPED_TEST(WorldTest, SeveralFixedPosesBendTheMap) {
  constexpr int kDim = TestFixture::kDim;
  const Pose<kDim> off = retract(this->world.truth.pose(30), PoseVector<kDim>(PoseVector<kDim>::Constant(0.05)));
  this->world.log.graph.fixed = {{0, this->world.truth.pose(0)}, {9, this->world.truth.pose(9)}, {30, off}};
  this->expect_optimum({0, 9, 30});
}

TYPED_TEST(WorldTest, PriorsOfPosesHoldTheMap) {
  this->world.log.graph.pose_factors.push_back(this->prior(3));
  this->world.log.graph.pose_factors.push_back(this->prior(20));
  this->expect_optimum({});
}

TYPED_TEST(WorldTest, PositionsHoldTheMap) {
  for (PoseIndex pose = 0; pose < 40; pose += 4) this->world.log.graph.pose_factors.push_back(this->gps(pose));
  this->expect_optimum({});
}

TYPED_TEST(WorldTest, PriorsOfFeaturesHoldTheMap) {
  for (FeatureIndex feature = 0; feature < 20; feature += 3) {
    this->world.log.graph.feature_factors.push_back(this->feature_prior(feature));
  }
  this->expect_optimum({});
}

TYPED_TEST(WorldTest, ADriftingSessionIsHeldByAFixedPoseAndAPosition) {
  this->world.log.graph.fixed = {{5, this->world.truth.pose(5)}};
  this->world.log.graph.pose_factors.push_back(this->gps(33));
  this->world.log.graph.feature_factors.push_back(this->feature_prior(2));
  this->expect_optimum({5});
}

TYPED_TEST(WorldTest, SessionsThatShareNothingMeetInTheWorld) {
  constexpr int kDim = TestFixture::kDim;
  this->place(small_world<kDim>({.poses = 20, .features = 0, .closures = 2, .sessions = 2}));
  this->world.log.graph.pose_factors.push_back(this->prior(2));
  this->world.log.graph.pose_factors.push_back(this->prior(15));
  this->world.log.graph.pose_factors.push_back(this->prior(24));
  this->world.log.graph.fixed = {{35, this->world.truth.pose(35)}};
  this->expect_optimum({35});
}

TYPED_TEST(WorldTest, TooFewPositionsLeaveTheMapFreeToTurn) {
  this->world.log.graph.pose_factors.push_back(this->gps(12));
  const auto result = run(this->world.log, RunOptions{});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::kBadInput);
  EXPECT_NE(result.error().message.find("free to turn as a whole about pose 12"), std::string::npos) << result.error().message;
}

/// A partial map in a frame of its own, and priors of its poses.
template <typename D>
class PlaceInWorldTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  using Priors = std::deque<PoseFactor<kDim>>;

  PlaceInWorldTest() {
    for (PoseIndex p = 0; p < 5; ++p) {
      truth_.push_back(random_.pose<kDim>(10.0, 2.0));
      partial_.poses.push_back(p);
      partial_.state.poses.push_back(compose(inverse(frame_), truth_[p]));
    }
  }

  /// A prior of the true position or rotation of a pose, or of both; its rotation is off by `turn` in each entry of the
  /// rotation vector (rad).
  PoseFactor<kDim> prior(PoseIndex pose, double turn, bool measures_position, bool measures_rotation) {
    PoseVector<kDim> weights;
    weights << Point<kDim>::Constant(measures_position), RotationVector<kDim>::Constant(measures_rotation);
    const Rotation<kDim> rotation = truth_[pose].rotation * Rotation<kDim>::exp(RotationVector<kDim>::Constant(turn));
    return {kWorld, pose, {truth_[pose].translation, rotation}, weights.asDiagonal()};
  }
  /// The first pose of the partial map as the priors place it.
  Pose<kDim> placed_by(const Priors& priors) const {
    SubmapGraph<kDim> graph;
    for (const auto& prior : priors) graph.priors.pose_factors.push_back(&prior);
    PartialMap<kDim> placed = partial_;
    place_in_world(graph, Pose<kDim>{}, placed);
    return placed.state.poses.front();
  }
  void expect_in_place(const Priors& priors) const { EXPECT_LT(local(placed_by(priors), truth_.front()).norm(), 1e-9); }

  testing::Random random_{3};
  Pose<kDim> frame_ = random_.pose<kDim>(100.0, 2.0);
  Table<PoseIndex, Pose<kDim>> truth_;
  PartialMap<kDim> partial_;
};
TYPED_TEST_SUITE(PlaceInWorldTest, testing::Dimensions);

TYPED_TEST(PlaceInWorldTest, OnePoseIsEnough) {
  this->expect_in_place({this->prior(2, 0.0, true, true)});
}

TYPED_TEST(PlaceInWorldTest, PositionsAreEnoughWhereTheyFixTheRotation) {
  this->expect_in_place({this->prior(0, 1.0, true, false), this->prior(1, 1.0, true, false), this->prior(2, 1.0, true, false)});
}

TYPED_TEST(PlaceInWorldTest, OnePositionSaysNothingOfTheRotation) {
  const auto placed = this->placed_by({this->prior(2, 1.0, true, false)});
  EXPECT_EQ(local(placed, this->partial_.state.poses.front()).norm(), 0.0);
}

TYPED_TEST(PlaceInWorldTest, ARotationSaysNothingOfThePosition) {
  auto rotation = this->prior(0, 0.0, false, true);
  rotation.measured.translation.setConstant(1e3);
  this->expect_in_place({rotation, this->prior(2, 0.0, true, true)});
}

TYPED_TEST(PlaceInWorldTest, AFeatureWhosePositionIsNotMeasuredSaysNothing) {
  constexpr int kDim = TestFixture::kDim;
  PartialMap<kDim> partial = this->partial_;
  std::vector<FeatureFactor<kDim>> priors;
  for (FeatureIndex f = 0; f < 5; ++f) {
    partial.features.push_back(f);
    partial.state.features.push_back(partial.state.poses[PoseIndex(f.value)].translation);
    priors.push_back({kWorld, f, this->truth_[PoseIndex(f.value)].translation, PointMatrix<kDim>::Identity()});
  }
  priors[3].measured.setConstant(1e3);
  priors[3].information(0, 0) = 0.0;
  SubmapGraph<kDim> graph;
  for (const auto& prior : priors) graph.priors.feature_factors.push_back(&prior);
  place_in_world(graph, Pose<kDim>{}, partial);
  EXPECT_LT(local(partial.state.poses.front(), this->truth_.front()).norm(), 1e-9);
}

TYPED_TEST(PlaceInWorldTest, TheAlignmentIsThatOfLeastDistances) {
  this->expect_in_place({this->prior(0, 1.0, true, true), this->prior(2, 0.0, true, true)});
}

}  // namespace
}  // namespace mapjoin
