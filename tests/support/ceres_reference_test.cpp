// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <tests/support/ceres_reference.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin::testing {
namespace {

template <typename D>
class CeresReferenceTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  /// Makes a chain with a closure and two features, observed without noise, and its true values; pose 0 is the origin.
  void SetUp() override {
    truth.poses.resize(4);
    for (PoseIndex i = 1; i < 4; ++i) truth.poses[i] = random.pose<kDim>();
    for (int i = 0; i < 2; ++i) truth.features.push_back(random.vector<kDim>(5.0));
    log.poses = {{0, 0}, {0, 1}, {0, 2}, {0, 3}};
    log.features = {{0}, {1}};
    log.sessions = {{0, 4}};
    log.graph.pose_factors = {edge(0, 1), edge(2, 1), edge(2, 3)};
    log.graph.pose_factors.push_back(edge(3, 0));
    log.graph.feature_factors = {observation(0, 0), observation(2, 0), observation(3, 1)};
  }
  PoseFactor<kDim> edge(PoseIndex base, PoseIndex target) {
    return {base, target, between(truth.poses[base], truth.poses[target]), random.information<kPoseDof<kDim>>()};
  }
  FeatureFactor<kDim> observation(PoseIndex base, FeatureIndex target) {
    return {base, target, transform_into(truth.poses[base], truth.features[target]), random.information<kDim>()};
  }
  double distance_from_truth(const Values<kDim>& values) const {
    double largest = 0.0;
    for (const PoseIndex i : indices(truth.poses)) {
      largest = std::max(largest, local(truth.poses[i], values.poses[i]).norm());
    }
    for (const FeatureIndex i : indices(truth.features)) {
      largest = std::max(largest, (truth.features[i] - values.features[i]).norm());
    }
    return largest;
  }

  Random random;
  Values<kDim> truth;
  Log<kDim> log;
};
TYPED_TEST_SUITE(CeresReferenceTest, Dimensions);

TYPED_TEST(CeresReferenceTest, EveryStartIsTheTruthWhereNothingIsNoisy) {
  EXPECT_LT(this->distance_from_truth(odometry_start(this->log)), 1e-12);
  EXPECT_LT(this->distance_from_truth(spanning_tree_start(this->log)), 1e-12);
  EXPECT_FALSE(file_start(this->log));
  this->log.initial.poses = this->truth.poses;
  EXPECT_LT(this->distance_from_truth(*file_start(this->log)), 1e-12);
}

TYPED_TEST(CeresReferenceTest, StartsHangFromAFixedPose) {
  constexpr int kDim = TestFixture::kDim;
  this->log.graph.fixed = {{2, this->truth.poses[2]}};
  EXPECT_LT(this->distance_from_truth(odometry_start(this->log)), 1e-12);
  EXPECT_LT(this->distance_from_truth(spanning_tree_start<kDim>(this->log)), 1e-12);
}

TYPED_TEST(CeresReferenceTest, ComesBackToTheTruthByEitherMethod) {
  constexpr int kDim = TestFixture::kDim;
  for (const auto method : {ReferenceMethod::kLevenbergMarquardt, ReferenceMethod::kDogleg}) {
    Values<kDim> start = this->truth;
    for (PoseIndex i = 1; i < 4; ++i) {
      start.poses[i] = retract(start.poses[i], this->random.template vector<kPoseDof<kDim>>(0.2));
    }
    const auto result = ceres_optimum(this->log, start, {.method = method});
    EXPECT_GT(result.initial_chi2, 1e-3);
    EXPECT_LT(result.chi2, 1e-12) << result.summary;
    EXPECT_LT(this->distance_from_truth(result.values), 1e-6);
  }
}

TYPED_TEST(CeresReferenceTest, CountsItsStepsWithoutTheStart) {
  constexpr int kDim = TestFixture::kDim;
  Values<kDim> start = this->truth;
  for (PoseIndex i = 1; i < 4; ++i) {
    start.poses[i] = retract(start.poses[i], this->random.template vector<kPoseDof<kDim>>(0.2));
  }
  for (const int most : {0, 1, 2}) EXPECT_EQ(ceres_optimum(this->log, start, {.max_iterations = most}).iterations, most);
}

TYPED_TEST(CeresReferenceTest, TwoMeasurementsOfOneStepMeetAtTheirWeightedMean) {
  constexpr int kDim = TestFixture::kDim;
  PoseFactor<kDim> once{0, 1, {}, PoseMatrix<kDim>::Identity()};
  PoseFactor<kDim> thrice = once;
  thrice.measured.translation[0] = 1.0;
  thrice.information *= 3.0;
  Log<kDim> log;
  log.poses = {{0, 0}, {0, 1}};
  log.graph.pose_factors = {once, thrice};
  const auto result = ceres_optimum(log, odometry_start(log));
  EXPECT_TRUE(result.converged) << result.summary;
  EXPECT_NEAR(result.values.poses[1].translation[0], 0.75, 1e-7);
  EXPECT_NEAR(result.chi2, 0.75 * 0.75 + 3.0 * 0.25 * 0.25, 1e-9);
}

TYPED_TEST(CeresReferenceTest, AMapOfSeveralTargetsIsOneObservation) {
  constexpr int kDim = TestFixture::kDim;
  // One map with a block-diagonal information matrix has the chi2 of separate observations.
  Log<kDim>& log = this->log;
  log.graph.pose_factors.resize(1);
  log.graph.feature_factors.resize(1);
  SubmapSet<kDim> set;
  LocalMap<kDim> map{0, {1}, {0}, {log.odometry()[0].measured}, {log.observations()[0].measured}, {}};
  map.information = Eigen::MatrixXd::Zero(kPoseDof<kDim> + kDim, kPoseDof<kDim> + kDim);
  map.information.topLeftCorner(kPoseDof<kDim>, kPoseDof<kDim>) = log.odometry()[0].information;
  map.information.bottomRightCorner(kDim, kDim) = log.observations()[0].information;
  set.graph.submaps = {map};
  Values<kDim> start = this->truth;
  start.poses[1] = this->random.template pose<kDim>();
  start.features[0].setOnes();
  const ReferenceOptions look_only{.max_iterations = 0};
  const double of_log = ceres_optimum(log, start, look_only).initial_chi2;
  EXPECT_GT(of_log, 1.0);
  EXPECT_NEAR(ceres_optimum(set, start, look_only).initial_chi2, of_log, 1e-12 * of_log);
}

}  // namespace
}  // namespace mapjoin::testing
