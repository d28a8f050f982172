// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <apps/picture/plotted_map.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin::apps {
namespace {

using ::mapjoin::testing::Dimensions;
using ::mapjoin::testing::Random;

template <typename Dimension>
class AlignmentTest : public ::testing::Test {};
TYPED_TEST_SUITE(AlignmentTest, Dimensions);

/// A map of random poses and features, with covariances.
template <int Dim>
PlottedMap<Dim> some_map() {
  Random random(7);
  PlottedMap<Dim> plotted;
  GlobalMap<Dim>& map = plotted.map;
  for (std::uint64_t k = 0; k < 8; ++k) {
    map.pose_ids.push_back({0, 3 * k});
    map.poses.push_back(random.template pose<Dim>());
    map.feature_ids.push_back({k});
    map.features.push_back(random.template pose<Dim>().translation);
    const PoseMatrix<Dim> A = PoseMatrix<Dim>::Identity() + 0.1 * PoseMatrix<Dim>::Constant(static_cast<double>(k));
    map.pose_covariances.push_back(A * A.transpose());
    map.feature_covariances.push_back((A * A.transpose()).template topLeftCorner<Dim, Dim>());
  }
  return plotted;
}

TYPED_TEST(AlignmentTest, TakesAMovedMapBackByWhatBothKnow) {
  constexpr int kDim = TypeParam::value;
  const PlottedMap<kDim> first = some_map<kDim>();
  PlottedMap<kDim> other = first;
  Random random(8);
  move(random.template pose<kDim>(), other);
  other.map.pose_ids[2] = {1, 99};  // another pose
  other.map.poses[2] = Pose<kDim>{};
  other.map.feature_ids.erase(other.map.feature_ids.begin());  // a feature fewer
  other.map.features.erase(other.map.features.begin());
  const auto frame = alignment(other, first);
  ASSERT_TRUE(frame);
  move(*frame, other);
  for (const PoseIndex k : {PoseIndex(0), PoseIndex(1), PoseIndex(3), PoseIndex(7)}) {
    EXPECT_LT((other.map.poses[k].translation - first.map.poses[k].translation).norm(), 1e-12);
    EXPECT_TRUE(other.map.poses[k].rotation.matrix().isApprox(first.map.poses[k].rotation.matrix(), 1e-12));
  }
  EXPECT_LT((other.map.features[0] - first.map.features[1]).norm(), 1e-12);
}

TYPED_TEST(AlignmentTest, TakesATrajectoryThatCountsItsPosesByItsTimes) {
  constexpr int kDim = TypeParam::value;
  PlottedMap<kDim> first = some_map<kDim>();
  PlottedMap<kDim> other;
  for (const PoseIndex k : indices(first.map.poses)) {
    first.map.stamps_ns.push_back(1'000'000'000 * std::int64_t{k.value});
    if (k.value % 2 != 0) continue;
    other.map.pose_ids.push_back({0, other.map.pose_ids.size()});
    other.map.poses.push_back(first.map.poses[k]);
    other.map.stamps_ns.push_back(first.map.stamps_ns[k] + 1'000'000);
  }
  Random random(11);
  const Pose<kDim> motion = random.template pose<kDim>();
  move(motion, other);
  const auto back = alignment(first, other);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_LT((back->translation - motion.translation).norm(), 1e-12);
  const auto frame = alignment(other, first);
  ASSERT_TRUE(frame) << frame.error().message;
  move(*frame, other);
  EXPECT_LT((other.map.poses[3].translation - first.map.poses[6].translation).norm(), 1e-12);

  for (PoseIndex k = 1; k < 8; k = k + 2) first.map.pose_ids[k].session = 1;
  const auto none = alignment(other, first);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message,
            "sessions 0 and 1 are both under way at 2.001 s, and a trajectory does not say of which it is");
}

/// The clock of one log counts from when the robot was switched on, a second after its first pose.
TYPED_TEST(AlignmentTest, TakesMapsByTheirNamesWhateverTheirClocksSay) {
  constexpr int kDim = TypeParam::value;
  PlottedMap<kDim> first = some_map<kDim>();
  for (const PoseIndex k : indices(first.map.poses)) {
    first.map.pose_ids[k].key = k.position();
    first.map.stamps_ns.push_back(1'000'000'000 * std::int64_t{k.value});
  }
  first.map.features.clear();
  first.map.feature_ids.clear();
  first.odometry = first.map.poses;
  PlottedMap<kDim> other = first;
  for (std::int64_t& stamp : other.map.stamps_ns) stamp -= 1'000'000'000;
  Random random(12);
  move(random.template pose<kDim>(), other);
  const auto frame = alignment(other, first);
  ASSERT_TRUE(frame) << frame.error().message;
  move(*frame, other);
  EXPECT_LT((other.map.poses[3].translation - first.map.poses[3].translation).norm(), 1e-12);
}

TYPED_TEST(AlignmentTest, IsNoneWhereMapsShareTooLittle) {
  constexpr int kDim = TypeParam::value;
  const PlottedMap<kDim> first = some_map<kDim>();
  PlottedMap<kDim> other = first;
  for (PoseId& id : other.map.pose_ids) id.session = 5;
  for (FeatureId& id : other.map.feature_ids) id.key += 100;
  other.map.feature_ids.front() = first.map.feature_ids.front();
  EXPECT_FALSE(alignment(other, first));
}

TYPED_TEST(AlignmentTest, TakesTheTruthByItsKnownPart) {
  constexpr int kDim = TypeParam::value;
  const PlottedMap<kDim> first = some_map<kDim>();
  Truth<kDim> truth;
  for (const auto& pose : first.map.poses) truth.poses.push_back(pose);
  truth.features.resize(first.map.features.size());
  truth.poses[4].reset();
  Random random(9);
  move(random.template pose<kDim>(), truth);
  const auto frame = alignment(truth, first.map);
  ASSERT_TRUE(frame);
  move(*frame, truth);
  EXPECT_LT((truth.poses[1]->translation - first.map.poses[1].translation).norm(), 1e-12);
  EXPECT_FALSE(truth.poses[4]);
}

TYPED_TEST(AlignmentTest, AMovedMapIsAsCertainInEveryDirection) {
  constexpr int kDim = TypeParam::value;
  const PlottedMap<kDim> first = some_map<kDim>();
  Random random(10);
  const Pose<kDim> motion = random.template pose<kDim>();
  PlottedMap<kDim> moved = first;
  move(motion, moved);
  // A step of a pose has the same Mahalanobis norm in either frame.
  PoseVector<kDim> step = PoseVector<kDim>::LinSpaced(0.3, 1.7);
  PoseVector<kDim> turned = step;
  turned.template head<kDim>() = motion.rotation.matrix() * step.template head<kDim>();
  for (const PoseIndex k : indices(first.map.poses)) {
    const double norm = step.dot(first.map.pose_covariances[k].inverse() * step);
    EXPECT_NEAR(turned.dot(moved.map.pose_covariances[k].inverse() * turned), norm, 1e-9 * norm);
    const Point<kDim> p = step.template head<kDim>();
    const Point<kDim> q = turned.template head<kDim>();
    const double of_feature = p.dot(first.map.feature_covariances[FeatureIndex(k.value)].inverse() * p);
    EXPECT_NEAR(q.dot(moved.map.feature_covariances[FeatureIndex(k.value)].inverse() * q), of_feature, 1e-9 * of_feature);
  }
}

}  // namespace
}  // namespace mapjoin::apps
