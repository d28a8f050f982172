// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>
#include <tests/support/small_world.hpp>
#include <tests/support/two_drives.hpp>

namespace mapjoin {
namespace {

template <typename D>
class OdometryChainTest : public ::testing::Test {};
TYPED_TEST_SUITE(OdometryChainTest, testing::Dimensions);

TYPED_TEST(OdometryChainTest, AddsUpTheCovariancesOfItsSteps) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = testing::small_world<kDim>({.poses = 12, .features = 4, .closures = 0, .range = 9.0}).log;
  const OdometryChain<kDim> chain(log);
  UncertainPose<kDim> composed;
  for (std::size_t k = 3; k < 9; ++k) composed = compose(composed, uncertain(log.odometry()[k]));
  const UncertainPose<kDim> relative = chain.relative(3, 9);
  EXPECT_LT(local(composed.mean, relative.mean).norm(), 1e-9);
  EXPECT_LT((composed.covariance - relative.covariance).norm(), 1e-6 * composed.covariance.norm());
  const UncertainPose<kDim> back = compose(relative, chain.relative(9, 3));
  EXPECT_LT(local(Pose<kDim>{}, back.mean).norm(), 1e-9);
}

TYPED_TEST(OdometryChainTest, CompletesEdgesByTheExtentOfTheMap) {
  constexpr int kDim = TypeParam::value;
  constexpr int kRot = kRotationDof<kDim>;
  PoseFactor<kDim> edge{0, 1, {}, 1e6 * PoseMatrix<kDim>::Identity(), {}};
  EXPECT_EQ(completed(edge, 300.0).information, edge.information);
  edge.information.template topLeftCorner<kDim, kDim>().setZero();
  const PoseMatrix<kDim> covariance = covariance_of(completed(edge, 300.0).information);
  EXPECT_NEAR(covariance(0, 0), 300.0 * 300.0, 1e-3);
  EXPECT_NEAR(covariance(kDim, kDim), 1e-6, 1e-12);
  edge.information.setZero();
  edge.information.template topLeftCorner<kDim, kDim>().setIdentity();
  EXPECT_NEAR(covariance_of(completed(edge, 300.0).information)(kDim + kRot - 1, kDim + kRot - 1), kSquaredTurn, 1e-6);
}

TEST(CovarianceOf, KeepsWhatIsMeasuredWhereRoundingMeasuresAnotherRow) {
  const Point<2> across(1.0, 6e-17);  // turned by a quarter
  const PointMatrix<2> W = 1e4 * across * across.transpose();
  EXPECT_NEAR(covariance_of(W)(0, 0), 1e-4, 1e-12);
}

TYPED_TEST(OdometryChainTest, HasTheLongestSideOfASessionForItsExtent) {
  EXPECT_NEAR(OdometryChain<TypeParam::value>(testing::two_drives<TypeParam::value>(300, {{0, 0}})).extent(), 299.0, 1e-9);
}

TYPED_TEST(OdometryChainTest, FusesEdgesThatRepeatOthers) {
  constexpr int kDim = TypeParam::value;
  Log<kDim> log = testing::small_world<kDim>({.poses = 3, .features = 0, .closures = 0}).log;
  PoseFactor<kDim> again = log.odometry()[0];  // backwards, with a third of the information
  again.information /= 3.0;
  again.measured = inverse(retract(again.measured, PoseVector<kDim>(PoseVector<kDim>::Constant(4e-3))));
  std::swap(again.base, again.target);
  log.graph.pose_factors.insert(log.graph.pose_factors.begin() + 1, again);
  const UncertainPose<kDim> step = OdometryChain<kDim>(log).relative(0, 1);
  PoseMatrix<kDim> information = PoseMatrix<kDim>::Zero();
  PoseVector<kDim> pull = PoseVector<kDim>::Zero();
  for (const auto& edge : log.odometry().first(2)) {
    const UncertainPose<kDim> one = forwards(edge);
    const PoseMatrix<kDim> W = one.covariance.inverse();
    information += W;
    pull += W * local(Pose<kDim>{}, compose(step.mean, inverse(one.mean)));
  }
  EXPECT_LT((information.inverse() * pull).norm(), 1e-4);  // the first edge alone would pull by 1e-3 in each entry
  EXPECT_LT((step.covariance * information - PoseMatrix<kDim>::Identity()).norm(), 1e-6);
}

TYPED_TEST(OdometryChainTest, HasAnAdjointThatTakesATwistFromTheRightToTheLeft) {
  constexpr int kDim = TypeParam::value;
  testing::Random random;
  const Pose<kDim> pose = random.pose<kDim>();
  const double h = 1e-6;
  for (int i = 0; i < kPoseDof<kDim>; ++i) {
    const PoseVector<kDim> twist = h * PoseVector<kDim>::Unit(i);
    const Pose<kDim> small = retract(Pose<kDim>{}, twist);
    const Pose<kDim> on_left = compose(compose(pose, small), inverse(pose));
    EXPECT_LT((local(Pose<kDim>{}, on_left) / h - adjoint(pose).col(i)).norm(), 1e-4);
  }
}

}  // namespace
}  // namespace mapjoin
