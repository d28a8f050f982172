// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/measure/trajectory_error.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::Random;

template <typename D>
class TrajectoryErrorTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  std::vector<Pose<kDim>> random_trajectory(std::size_t poses) {
    std::vector<Pose<kDim>> trajectory;
    for (std::size_t i = 0; i < poses; ++i) trajectory.push_back(random.template pose<kDim>());
    return trajectory;
  }
  static std::vector<Pose<kDim>> moved(const Pose<kDim>& motion, std::vector<Pose<kDim>> trajectory) {
    for (auto& pose : trajectory) pose = compose(motion, pose);
    return trajectory;
  }
  Random random;
};
TYPED_TEST_SUITE(TrajectoryErrorTest, testing::Dimensions);

TYPED_TEST(TrajectoryErrorTest, AlignmentFindsTheRigidMotionAndNeverAReflection) {
  constexpr int kDim = TestFixture::kDim;
  const Pose<kDim> motion = this->random.template pose<kDim>();
  std::vector<Point<kDim>> from, to, mirrored;
  for (int i = 0; i < 10; ++i) {
    from.push_back(this->random.template vector<kDim>(3.0));
    to.push_back(transform(motion, from.back()));
    mirrored.push_back(from.back());
    mirrored.back()[0] *= -1.0;
  }
  EXPECT_LT(local(align(from, to), motion).norm(), 1e-12);
  EXPECT_NEAR(align(from, mirrored).rotation.matrix().determinant(), 1.0, 1e-12);
}

TYPED_TEST(TrajectoryErrorTest, AlignmentIsALeastSquaresOptimum) {
  constexpr int kDim = TestFixture::kDim;
  std::vector<Point<kDim>> from, to;
  for (int i = 0; i < 10; ++i) {
    from.push_back(this->random.template vector<kDim>(3.0));
    to.push_back(this->random.template vector<kDim>(3.0));
  }
  const auto cost = [&](const Pose<kDim>& motion) {
    double sum = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) sum += (to[i] - transform(motion, from[i])).squaredNorm();
    return sum;
  };
  const Pose<kDim> best = align(from, to);
  for (int i = 0; i < 100; ++i) {
    EXPECT_GT(cost(retract(best, this->random.template vector<kPoseDof<kDim>>(0.01))), cost(best));
  }
}

TYPED_TEST(TrajectoryErrorTest, ErrorsDoNotDependOnTheFrameOfTheEstimate) {
  constexpr int kDim = TestFixture::kDim;
  const auto truth = this->random_trajectory(20);
  const Pose<kDim> motion = this->random.template pose<kDim>();
  const auto estimate = this->moved(motion, truth);
  EXPECT_LT(absolute_trajectory_error(estimate, truth).errors.translation.max, 1e-12);
  EXPECT_LT(absolute_trajectory_error(estimate, truth).errors.rotation.max, 1e-7);
  EXPECT_LT(relative_pose_error(estimate, truth, 3).translation.max, 1e-12);
}

TYPED_TEST(TrajectoryErrorTest, AbsoluteErrorOfOnePoseAsideIsSharedOut) {
  constexpr int kDim = TestFixture::kDim;
  // A line of 10 poses, then the same with the last pose d off the line's direction: alignment may only reduce the error
  // below d/sqrt(10), and cannot remove it.
  std::vector<Pose<kDim>> truth(10);
  for (std::size_t i = 0; i < truth.size(); ++i) truth[i].translation[0] = static_cast<double>(i);
  auto estimate = truth;
  estimate.back().translation[0] += 0.5;
  const auto error = absolute_trajectory_error(estimate, truth).errors.translation;
  EXPECT_NEAR(error.rms, 0.5 * std::sqrt(0.1 * 0.9), 1e-12);
  EXPECT_NEAR(error.max, 0.45, 1e-12);
  EXPECT_EQ(error.count, 10u);
}

TYPED_TEST(TrajectoryErrorTest, RelativeErrorIsTheDriftOverTheSpan) {
  constexpr int kDim = TestFixture::kDim;
  // Straight on by 1 m a step, estimated 1 % too long and turning 0.01 rad a step where it stands.
  std::vector<Pose<kDim>> truth(30), estimate(30);
  RotationVector<kDim> turn = RotationVector<kDim>::Zero();
  turn[0] = 0.01;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    truth[i].translation[0] = static_cast<double>(i);
    estimate[i].translation[0] = 1.01 * static_cast<double>(i);
  }
  EXPECT_NEAR(relative_pose_error(estimate, truth, 5).translation.rms, 0.05, 1e-12);
  EXPECT_EQ(relative_pose_error(estimate, truth, 5).translation.count, 25u);
  for (std::size_t i = 0; i < truth.size(); ++i) estimate[i].rotation = Rotation<kDim>::exp(static_cast<double>(i) * turn);
  EXPECT_NEAR(relative_pose_error(estimate, truth, 7).rotation.max, 0.07, 1e-12);
  EXPECT_THROW(relative_pose_error(estimate, truth, 0), std::invalid_argument);
}

TYPED_TEST(TrajectoryErrorTest, MapsAreComparedByIdAndWhatOnlyOneHoldsIsCounted) {
  constexpr int kDim = TestFixture::kDim;
  GlobalMap<kDim> a, b;
  a.pose_ids = {{0, 1}, {0, 2}};
  a.poses = Table<PoseIndex, Pose<kDim>>(this->random_trajectory(2));
  a.feature_ids = {{5}, {6}};
  a.features = {Point<kDim>::Zero(), Point<kDim>::Ones()};
  b.pose_ids = {{0, 2}, {0, 7}, {1, 1}};
  b.poses = {a.poses[1], a.poses[0], a.poses[0]};
  b.poses[0].translation[1] += 0.25;
  b.feature_ids = {{6}};
  b.features = {2.0 * Point<kDim>::Ones()};
  const MapDifference difference = map_difference(a, b);
  EXPECT_EQ(difference.poses.translation.count, 1u);
  EXPECT_NEAR(difference.poses.translation.max, 0.25, 1e-12);
  EXPECT_NEAR(difference.features.rms, std::sqrt(double{kDim}), 1e-12);
  EXPECT_EQ(difference.unmatched, 4u);
}

}  // namespace
}  // namespace mapjoin
