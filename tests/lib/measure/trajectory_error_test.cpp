// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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
  EXPECT_LT(relative_pose_error(estimate, truth, pairs_by_steps(truth.size(), 3)).translation.max, 1e-12);
}

TYPED_TEST(TrajectoryErrorTest, AbsoluteErrorOfOnePoseAsideIsSharedOut) {
  constexpr int kDim = TestFixture::kDim;
  // A line of 10 poses, and the same with the last pose d = 0.5 m further along it. Alignment shifts all by d/10: an rms of
  // d/√10 becomes d √(0.1 · 0.9).
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
  // Steps of 1 m straight ahead, estimated 1 % too long; later also headings that turn by 0.01 rad per step.
  std::vector<Pose<kDim>> truth(30), estimate(30);
  RotationVector<kDim> turn = RotationVector<kDim>::Zero();
  turn[0] = 0.01;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    truth[i].translation[0] = static_cast<double>(i);
    estimate[i].translation[0] = 1.01 * static_cast<double>(i);
  }
  EXPECT_NEAR(relative_pose_error(estimate, truth, pairs_by_steps(truth.size(), 5)).translation.rms, 0.05, 1e-12);
  EXPECT_EQ(relative_pose_error(estimate, truth, pairs_by_steps(truth.size(), 5)).translation.count, 25u);
  for (std::size_t i = 0; i < truth.size(); ++i) estimate[i].rotation = Rotation<kDim>::exp(static_cast<double>(i) * turn);
  EXPECT_NEAR(relative_pose_error(estimate, truth, pairs_by_steps(truth.size(), 7)).rotation.max, 0.07, 1e-12);
  EXPECT_THROW(pairs_by_steps(truth.size(), 0), std::invalid_argument);
  EXPECT_THROW(relative_pose_error(estimate, truth, {{0, truth.size()}}), std::invalid_argument);
  EXPECT_THROW(relative_pose_error(estimate, truth, {{truth.size(), 0}}), std::invalid_argument);
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

/// The homogeneous matrix of a pose: evo's representation, in which its definitions are computed here independently.
template <int Dim>
Eigen::MatrixXd matrix_of(const Pose<Dim>& pose) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(4, 4);
  T.block(0, 0, Dim, Dim) = pose.rotation.matrix();
  T.block(0, 3, Dim, 1) = pose.translation;
  return T;
}
double angle_of(const Eigen::MatrixXd& T) {
  const double sine = (T.topLeftCorner(3, 3) - T.topLeftCorner(3, 3).transpose()).norm() / std::sqrt(2.0);
  return std::atan2(sine, T.topLeftCorner(3, 3).trace() - 1.0);
}

/// Expects the statistics of evo, as NumPy computes them.
void expect_as_evo(const ErrorSummary& summary, std::vector<double> errors) {
  std::ranges::sort(errors);
  const Eigen::Map<const Eigen::ArrayXd> e(errors.data(), static_cast<Eigen::Index>(errors.size()));
  EXPECT_EQ(summary.count, errors.size());
  EXPECT_NEAR(summary.rms, std::sqrt(e.square().mean()), 1e-9);
  EXPECT_NEAR(summary.mean, e.mean(), 1e-9);
  EXPECT_NEAR(summary.deviation, std::sqrt((e - e.mean()).square().mean()), 1e-9);
  EXPECT_NEAR(summary.min, e.minCoeff(), 1e-9);
  EXPECT_NEAR(summary.max, e.maxCoeff(), 1e-9);
  const std::size_t half = errors.size() / 2;
  EXPECT_NEAR(summary.median, errors.size() % 2 == 1 ? errors[half] : 0.5 * (errors[half - 1] + errors[half]), 1e-9);
}

TYPED_TEST(TrajectoryErrorTest, AbsoluteErrorsAreEvos) {
  for (const std::size_t poses : {20u, 21u}) {
    const auto estimate = this->random_trajectory(poses);
    const auto truth = this->random_trajectory(poses);
    for (const auto& [alignment, name] : enum_names(TrajectoryAlignment())) {
      const auto found = absolute_trajectory_error(estimate, truth, alignment);
      Eigen::MatrixXd motion = Eigen::MatrixXd::Identity(4, 4);
      if (alignment == TrajectoryAlignment::kOrigin) motion = matrix_of(truth[0]) * matrix_of(estimate[0]).inverse();
      if (alignment == TrajectoryAlignment::kRigid)
        motion = matrix_of(found.alignment);  // tested by AlignmentIsALeastSquaresOptimum
      std::vector<double> translations;
      std::vector<double> rotations;
      for (std::size_t i = 0; i < poses; ++i) {
        const Eigen::MatrixXd E = matrix_of(truth[i]).inverse() * motion * matrix_of(estimate[i]);
        translations.push_back(E.topRightCorner(3, 1).norm());
        rotations.push_back(angle_of(E));
      }
      expect_as_evo(found.errors.translation, translations);
      expect_as_evo(found.errors.rotation, rotations);
    }
  }
}

/// The pairs by filter_pairs_by_path() of evo, with its tolerance of a tenth.
template <int Dim>
PosePairs pairs_as_evo(const std::vector<Pose<Dim>>& poses, double delta, SpanPairs which) {
  PosePairs pairs;
  const auto distance = [&](std::size_t i, std::size_t j) {
    double sum = 0.0;
    for (std::size_t k = i; k < j; ++k) sum += (poses[k + 1].translation - poses[k].translation).norm();
    return sum;
  };
  if (which == SpanPairs::kAll) {
    for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
      std::size_t best = i + 1;
      for (std::size_t j = i + 1; j < poses.size(); ++j) {
        if (std::abs(distance(i, j) - delta) < std::abs(distance(i, best) - delta)) best = j;
      }
      if (std::abs(distance(i, best) - delta) <= 0.1 * delta) pairs.emplace_back(i, best);
    }
    return pairs;
  }
  std::vector<std::size_t> ids;
  double current = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i > 0) current += distance(i - 1, i);
    if (current < delta) continue;
    ids.push_back(i);
    current = 0.0;
  }
  for (std::size_t k = 0; k + 1 < ids.size(); ++k) pairs.emplace_back(ids[k], ids[k + 1]);
  return pairs;
}

TYPED_TEST(TrajectoryErrorTest, RelativeErrorsAreEvos) {
  const auto estimate = this->random_trajectory(60);
  const auto truth = this->random_trajectory(60);
  const auto expect_errors = [&](const PosePairs& pairs) {
    std::vector<double> translations;
    std::vector<double> rotations;
    for (const auto& [i, j] : pairs) {
      const Eigen::MatrixXd Q = matrix_of(truth[i]).inverse() * matrix_of(truth[j]);
      const Eigen::MatrixXd P = matrix_of(estimate[i]).inverse() * matrix_of(estimate[j]);
      const Eigen::MatrixXd E = Q.inverse() * P;
      translations.push_back(E.topRightCorner(3, 1).norm());
      rotations.push_back(angle_of(E));
    }
    const PoseErrorSummary found = relative_pose_error(estimate, truth, pairs);
    expect_as_evo(found.translation, translations);
    expect_as_evo(found.rotation, rotations);
  };
  expect_errors(pairs_by_steps(60, 7, SpanPairs::kAll));
  EXPECT_EQ(pairs_by_steps(8, 3, SpanPairs::kSuccessive), (PosePairs{{0, 3}, {3, 6}}));
  EXPECT_EQ(pairs_by_steps(5, 3, SpanPairs::kAll), (PosePairs{{0, 3}, {1, 4}}));
  for (const SpanPairs which : {SpanPairs::kAll, SpanPairs::kSuccessive}) {
    for (const double metres : {1.0, 20.0, 55.0, 1e4}) {
      EXPECT_EQ(pairs_by_path(estimate, metres, which), pairs_as_evo(estimate, metres, which)) << metres;
    }
    expect_errors(pairs_by_path(estimate, 20.0, which));
  }
}

TYPED_TEST(TrajectoryErrorTest, OfPosesAtOnePlaceTheFirstEndsASpan) {
  constexpr int kDim = TestFixture::kDim;
  std::vector<Pose<kDim>> poses;
  for (const double x : {0.0, 1.0, 1.0, 2.0, 2.0, 2.0}) poses.push_back({x * Point<kDim>::UnitX(), {}});
  EXPECT_EQ(pairs_by_path(poses, 1.0, SpanPairs::kAll), pairs_as_evo(poses, 1.0, SpanPairs::kAll));
  EXPECT_EQ(pairs_by_path(poses, 2.1, SpanPairs::kAll), pairs_as_evo(poses, 2.1, SpanPairs::kAll));
}

}  // namespace
}  // namespace mapjoin
