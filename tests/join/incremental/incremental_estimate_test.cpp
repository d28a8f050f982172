// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <mapjoin/join/incremental/incremental_estimate.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// A pose measures how far ahead a feature is, wrongly, and nothing else; that hardly depends on a small turn, so that a step
/// would turn the pose far.
TEST(IncrementalEstimate, AStepThatWouldRaiseChi2IsNotTaken) {
  const Pose<2> start{Point<2>::Zero(), Rotation<2>(0.05)};
  const PoseVector<2> weights(1e6, 1e6, 1e-9);
  const LocalMap<2> position{kWorld, {0}, {}, {Pose<2>{}}, {}, weights.asDiagonal()};
  const LocalMap<2> sight{0, {}, {0}, {}, {Point<2>(5.0, 0.0)}, Vector<2>(1.0, 1e-9).asDiagonal()};
  IncrementalEstimate<2> estimate;
  const JoinedIndex pose = estimate.add_variable(true, start, false);
  const JoinedIndex feature = estimate.add_variable(false, {Point<2>(10.0, 0.0), {}}, true);
  estimate.add_factor({position, {kJoinedWorld, pose}});
  estimate.add_factor({sight, {pose, feature}});
  const double chi2 = estimate.chi2();
  const Settling settling = estimate.settle({});
  EXPECT_FALSE(settling.converged);
  EXPECT_EQ(local(estimate.variables()[pose].value, start).norm(), 0.0);
  EXPECT_NEAR(estimate.chi2(), chi2, 1e-9 * chi2);
}

/// A prior says so little that chi2 allows its error before it is linearised at the pose that it turns so far.
TEST(IncrementalEstimate, APoseThatHasTurnedFarEndsWithItsMapsInItsNewReference) {
  const Pose<3> place{Point<3>(1.0, 2.0, 3.0), Rotation<3>::exp(RotationVector<3>(0.3, 0.4, 1.1))};
  const LocalMap<3> prior{kWorld, {0}, {}, {place}, {}, 1e-6 * PoseMatrix<3>::Identity()};
  IncrementalEstimate<3> estimate;
  const JoinedIndex pose = estimate.add_variable(true, {}, false);
  estimate.add_factor({prior, {kJoinedWorld, pose}});
  EXPECT_TRUE(estimate.settle({}).converged);
  EXPECT_LT(local(estimate.variables()[pose].value, place).norm(), 1e-9);
  EXPECT_LT((1e-6 * estimate.kept().covariance({&pose, 1}).value() - PoseMatrix<3>::Identity()).norm(), 1e-9);
}

/// Features that an anchored pose has seen twice each, once a standard deviation (1 m) too far and once too near: at the
/// optimum, chi2 is 2 for each.
class DeferralTest : public ::testing::Test {
 protected:
  void see_features(int count) {
    pose_ = estimate_.add_variable(true, {}, true);
    for (int k = 0; k < count; ++k) {
      features_.push_back(estimate_.add_variable(false, {}, false));
      see(features_.back(), 1.0);
      see(features_.back(), -1.0);
    }
    ASSERT_TRUE(estimate_.settle({}).converged);
    ASSERT_NEAR(estimate_.chi2(), 2.0 * count, 1e-9 * count);
  }
  FactorIndex see(JoinedIndex feature, double x) {
    maps_.push_back({0, {}, {0}, {}, {Point<2>(x, 0.0)}, Vector<2>::Ones().asDiagonal()});
    return estimate_.add_factor({maps_.back(), {pose_, feature}});
  }
  /// A third sight of a feature, for which chi2 would fall by `gain` if the feature went where all three want it to be: 2 x² +
  /// (x - d)² is d² at 0, and 2/3 d² at d/3.
  FactorIndex see_with_gain(JoinedIndex feature, double gain) { return see(feature, std::sqrt(3.0 * gain)); }
  double x(JoinedIndex feature) const { return estimate_.variable(feature).value.translation.x(); }

  std::deque<LocalMap<2>> maps_;
  IncrementalEstimate<2> estimate_;
  JoinedIndex pose_;
  std::vector<JoinedIndex> features_;
};

TEST_F(DeferralTest, OnlyWhatIsNewMovesAndTheRestAtTheNextSettling) {
  see_features(200);  // 7e-4 of chi2, which may be missed, are 0.28
  const JoinedIndex added = estimate_.add_variable(false, {}, false);
  see(added, 7.0);
  see_with_gain(features_[3], 0.15);
  const auto deferral = estimate_.defer();
  ASSERT_TRUE(deferral && deferral->converged);
  EXPECT_EQ(deferral->eliminated, 0u);
  EXPECT_EQ(deferral->moved.metres, 0.0);
  EXPECT_NEAR(x(added), 7.0, 1e-12);
  EXPECT_EQ(x(features_[3]), 0.0);
  EXPECT_NEAR(estimate_.chi2(), 400.45, 1e-9);
  const Settling settling = estimate_.settle({});
  EXPECT_GT(settling.eliminated, 0u);
  EXPECT_NEAR(settling.moved.metres, std::sqrt(0.45) / 3.0, 1e-9);
  EXPECT_NEAR(estimate_.chi2(), 400.3, 1e-9);
}

TEST_F(DeferralTest, EndsWhereTheRestWouldGainMoreThanItsShareOfChi2) {
  see_features(200);
  see_with_gain(features_[3], 0.15);
  EXPECT_TRUE(estimate_.defer());
  see_with_gain(features_[5], 0.11);
  EXPECT_TRUE(estimate_.defer());
  see_with_gain(features_[7], 0.03);
  EXPECT_FALSE(estimate_.defer());
}

TEST_F(DeferralTest, EndsWhereAMapWouldGainMoreThanAStandardDeviationInEachRow) {
  see_features(4000);  // 7e-4 of chi2, which may be missed, are 5.6
  see_with_gain(features_[3], 1.9);
  EXPECT_TRUE(estimate_.defer());
  see_with_gain(features_[5], 2.1);
  EXPECT_FALSE(estimate_.defer());
}

TEST_F(DeferralTest, LeavesAllAsItStoodWhereItIsNotEnough) {
  see_features(200);
  const JoinedIndex added = estimate_.add_variable(false, {}, false);
  see(added, 7.0);
  see_with_gain(features_[5], 0.4);
  const double chi2 = estimate_.chi2();
  EXPECT_FALSE(estimate_.defer());
  EXPECT_EQ(x(added), 0.0);
  EXPECT_NEAR(estimate_.chi2(), chi2, 1e-9 * chi2);
  EXPECT_TRUE(estimate_.settle({}).converged);
  EXPECT_NEAR(x(added), 7.0, 1e-12);
  EXPECT_NEAR(estimate_.chi2(), 400.8, 1e-9);
}

TEST_F(DeferralTest, EndsWhereTooMuchIsNew) {
  see_features(1);
  for (int k = 0; k < 32; ++k) {
    see(estimate_.add_variable(false, {}, false), 1.0);
    EXPECT_TRUE(estimate_.defer()) << k;
  }
  see(estimate_.add_variable(false, {}, false), 1.0);
  EXPECT_FALSE(estimate_.defer());
  estimate_.settle({});
  see(estimate_.add_variable(false, {}, false), 1.0);
  EXPECT_TRUE(estimate_.defer());
}

TEST_F(DeferralTest, IsNotTriedAgainAtOnceWhereFarTooMuchWasMissed) {
  see_features(200);
  see_with_gain(features_[3], 1.4);  // five times what may be missed
  EXPECT_FALSE(estimate_.defer());
  for (const bool is_tried : {false, false, false, true}) {  // 1.4, 0.7 and 0.35 are above 0.28
    estimate_.settle({});
    see(features_[9], 0.0);
    EXPECT_EQ(estimate_.defer().has_value(), is_tried);
  }
}

TEST_F(DeferralTest, ADeferredFactorCanBeTakenOutAgain) {
  see_features(200);
  see(features_[2], 0.1);
  ASSERT_TRUE(estimate_.defer());
  const FactorIndex wrong = see_with_gain(features_[3], 0.2);
  ASSERT_TRUE(estimate_.defer());
  estimate_.remove_factor(wrong);
  EXPECT_NEAR(estimate_.chi2(), 400.01, 1e-9);
  see_with_gain(features_[4], 0.2);  // too much, were the wrong one still there
  EXPECT_TRUE(estimate_.defer());
  estimate_.settle({});
  EXPECT_EQ(x(features_[3]), 0.0);
  EXPECT_GT(x(features_[4]), 0.2);
}

TEST_F(DeferralTest, CovariancesAreThoseOfTheEstimateAsItStands) {
  see_features(200);
  const JoinedIndex added = estimate_.add_variable(false, {}, false);
  see(added, 7.0);
  see(features_[3], 0.1);
  ASSERT_TRUE(estimate_.defer());
  const auto covariance_of = [&](JoinedIndex v) { return estimate_.kept().covariance({&v, 1}).value(); };
  EXPECT_LT((covariance_of(added) - Eigen::Matrix2d::Identity()).norm(), 1e-12);
  EXPECT_LT((covariance_of(features_[3]) - Eigen::Matrix2d::Identity() / 2.0).norm(), 1e-12);
  estimate_.settle({});
  EXPECT_LT((covariance_of(added) - Eigen::Matrix2d::Identity()).norm(), 1e-12);
  EXPECT_LT((covariance_of(features_[3]) - Eigen::Matrix2d::Identity() / 3.0).norm(), 1e-12);
}

}  // namespace
}  // namespace mapjoin
