// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/robust/repeated_odometry.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>
#include <tests/support/same_log.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class RepeatedOdometryTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  PoseMatrix<kDim> information() { return 1e2 * random_.information<kPoseDof<kDim>>(); }
  Pose<kDim> nearly(const Pose<kDim>& pose) { return testing::noisy(pose, 1e-3, random_); }

  /// Poses 0 to 3, of which 1 and 2 are tied three times, once from 2 to 1.
  Log<kDim> log() {
    const Pose<kDim> step = random_.pose<kDim>();
    LogBuilder<kDim> builder("repeated");
    builder.add_pose_edge({0, 0}, {0, 1}, step, information());
    builder.add_pose_edge({0, 1}, {0, 2}, nearly(step), information());
    builder.add_pose_edge({0, 2}, {0, 1}, nearly(inverse(step)), information());
    builder.add_pose_edge({0, 1}, {0, 2}, nearly(step), information());
    builder.add_pose_edge({0, 2}, {0, 3}, step, information());
    return std::move(builder).finish().value();
  }

 private:
  testing::Random random_{3};
};
TYPED_TEST_SUITE(RepeatedOdometryTest, testing::Dimensions);

/// The least chi2 of two edges between the same poses.
template <int Dim>
double least_chi2(const PoseFactor<Dim>& a, const PoseFactor<Dim>& b) {
  testing::DenseSlam<Dim> slam{{a, b}, {}, {std::max(a.base, a.target)}, {}};
  Values<Dim> values;
  values.poses.resize(4);
  const bool is_forwards = a.base < a.target;
  values.poses[slam.free_poses.front()] = is_forwards ? a.measured : inverse(a.measured);
  return slam.linearise(slam.optimum(values)).chi2;
}

TYPED_TEST(RepeatedOdometryTest, HasTheLeastChi2ThatAnEdgeAndTheFirstOneLeave) {
  const auto log = this->log();
  ASSERT_EQ(log.odometry().size(), 5U);
  const std::vector<RepeatedOdometry> repeated = repeated_odometry(log);
  ASSERT_EQ(repeated.size(), 2U);
  for (const std::size_t k : {0U, 1U}) {
    EXPECT_EQ(repeated[k].edge, 2 + k);
    const double expected = least_chi2(log.odometry()[1], log.odometry()[2 + k]);
    EXPECT_NEAR(repeated[k].chi2, expected, 0.01 * expected);
  }
}

TYPED_TEST(RepeatedOdometryTest, IsRejectedWhereItContradictsTheFirstOne) {
  constexpr int kDim = TypeParam::value;
  Log<kDim> log = this->log();
  log.graph.pose_factors[2].measured.translation[0] += 10.0;
  const auto inliers = without_contradicted_odometry(log, 0.99);
  ASSERT_EQ(inliers.rejected.size(), 1U);
  EXPECT_EQ(inliers.rejected[0].misfit.kind, PartKind::kOdometry);
  EXPECT_LT(inliers.rejected[0].misfit.probability, 0.01);
  ASSERT_EQ(inliers.input.odometry().size(), 4U);
  EXPECT_EQ(inliers.input.odometry()[2].base, log.odometry()[3].base);
}

TYPED_TEST(RepeatedOdometryTest, LeavesAllElseWhereItIsRejected) {
  constexpr int kDim = TypeParam::value;
  Log<kDim> log = this->log();
  for (const std::size_t wrong : {2U, 3U}) log.graph.pose_factors[wrong].measured.translation[0] += 10.0;
  log.graph.pose_factors.push_back({kWorld, 3, {}, PoseMatrix<kDim>::Identity()});
  const auto inliers = without_contradicted_odometry(log, 0.99);
  EXPECT_EQ(inliers.rejected.size(), 2U);
  ASSERT_EQ(inliers.input.graph.pose_factors.size(), 4U);
  testing::expect_same_observations(inliers.input.odometry().first(2), log.odometry().first(2), {});
  testing::expect_same_observations(inliers.input.odometry().last(1), log.odometry().last(1), {});
  testing::expect_same_observations(inliers.input.pose_priors(), log.pose_priors(), {});
}

TYPED_TEST(RepeatedOdometryTest, IsNothingWhereEachStepIsToldOnce) {
  EXPECT_TRUE(repeated_odometry(testing::small_world<TypeParam::value>().log).empty());
}

}  // namespace
}  // namespace mapjoin
