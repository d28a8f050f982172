// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <numbers>
#include <tests/join/incremental/incremental_join_fixture.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/dense_information.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <tuple>

namespace mapjoin {
namespace {

using testing::small_world;

template <typename D>
class IncrementalJoinTest : public testing::IncrementalJoinFixture<D> {};
TYPED_TEST_SUITE(IncrementalJoinTest, testing::Dimensions);

TYPED_TEST(IncrementalJoinTest, IsAtTheOptimumAfterEveryMap) {
  const auto updates = this->submap_updates_of({.poses = 100, .features = 60, .closures = 6}, 6.0);
  testing::expect_optimal_at_every_kth_step(updates, 1);
}

TYPED_TEST(IncrementalJoinTest, EndsWhereAJoinOfAllMapsEnds) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 100, .features = 60, .closures = 6}, 6.0);
  IncrementalJoin<kDim> joined;
  AddedUpdate last;
  for (const auto& update : updates) last = joined.add(update).value();
  const auto batch = this->batch(updates);
  // The difference of chi2 is that of the states in squared standard deviations, all of them together.
  EXPECT_NEAR(last.chi2, batch.result.chi2, 0.02);
  EXPECT_EQ(last.dof, batch.result.dof);
  EXPECT_LT(this->difference(joined, updates), 0.02);
}

TYPED_TEST(IncrementalJoinTest, JoinsRawSegmentsOfAPoseGraph) {
  const auto updates = this->submap_updates_of({.poses = 60, .features = 0, .closures = 40, .reversed_odometry = true}, 5.0);
  ASSERT_TRUE(std::any_of(updates.begin(), updates.end(), [](const auto& update) { return update.graph.submaps.empty(); }));
  testing::expect_optimal_at_every_kth_step(updates, 1);
}

TYPED_TEST(IncrementalJoinTest, SaysHowFarTheEstimateHasMoved) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 100, .features = 60, .closures = 6}, 6.0);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) {
    std::vector<std::pair<PoseId, Pose<kDim>>> before;
    for (std::uint64_t p = 0; p < 100; ++p) {
      if (const auto* pose = joined.pose({0, p})) before.emplace_back(PoseId{0, p}, *pose);
    }
    const AddedUpdate added = joined.add(update).value();
    double metres = 0.0;
    double radians = 0.0;
    for (const auto& [p, was] : before) {
      const auto step = local(was, *joined.pose(p));
      metres = std::max(metres, step.template head<kDim>().norm());
      radians = std::max(radians, step.template tail<kRotationDof<kDim>>().norm());
    }
    EXPECT_GE(added.metres, metres);  // a feature may have moved farther
    EXPECT_DOUBLE_EQ(added.radians, radians);
  }
}

TYPED_TEST(IncrementalJoinTest, LooksAnewWhereOneMapInAThousandWouldFitAsBadly) {
  constexpr int kDim = TestFixture::kDim;
  const auto as_given = this->submap_updates_of({.poses = 60, .features = 60, .closures = 0}, 6.0);
  auto too_certain = as_given;  // the fit so far says what is probable, not the covariances
  for (auto& update : too_certain) {
    for (auto& map : update.graph.submaps) map.information *= 1e4;
  }
  for (const auto& [updates, probability, looks] :
       {std::tuple{as_given, 5e-4, true}, {as_given, 2e-3, false}, {too_certain, 5e-4, true}, {too_certain, 2e-3, false}}) {
    IncrementalJoin<kDim> joined;
    AddedUpdate last;
    for (const auto& update : updates) last = joined.add(update).value();
    // A closure too weak to move anything, off by as much as makes chi2 grow so improbably.
    const double scale = std::max(1.0, last.chi2 / static_cast<double>(last.dof));
    const double growth = scale * chi_squared_quantile(1.0 - probability, kPoseDof<kDim>);
    constexpr double kWeight = 1e-6;
    Pose<kDim> measured = between(*joined.pose(first_pose(updates[2])), *joined.pose(first_pose(updates[5])));
    measured.translation.x() += std::sqrt(growth / kWeight);
    const auto weak = this->closure(updates[2], updates[5], measured, kWeight * PoseMatrix<kDim>::Identity());
    const AddedUpdate added = joined.add(weak).value();
    EXPECT_NEAR(added.chi2 - last.chi2, growth, 0.02 * growth);
    EXPECT_EQ(added.batch_checked, looks);
    EXPECT_TRUE(added.converged);
  }
}

TYPED_TEST(IncrementalJoinTest, KeepsItsEstimateWhereAnotherIsNoBetter) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 60, .features = 60, .closures = 0, .noise = 0.0}, 6.0);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  Pose<kDim> measured = between(*joined.pose(first_pose(updates[2])), *joined.pose(first_pose(updates[5])));
  measured.translation.x() += 1e4;
  const auto wrong = this->closure(updates[2], updates[5], measured, 1e-6 * PoseMatrix<kDim>::Identity());
  const AddedUpdate added = joined.add(wrong).value();
  EXPECT_TRUE(added.batch_checked);
  EXPECT_FALSE(added.batch_adopted);
}

/// A pose is measured from another one several times, each time a third of a turn further, and each measurement outweighs all
/// before. A whole turn from the rotation that its step refers to, a rotation vector would determine nothing any more.
TEST(IncrementalJoinInSpace, APoseMayTurnAllTheWayRound) {
  IncrementalJoin<3> joined;
  SubmapUpdate<3> update;
  update.poses = {{0, 0}, {0, 1}};
  update.segments = {{0, 1, false}};
  double heading = 0.0;
  double weight = 0.0;
  for (const double next : {1e-6, 1e-3, 0.1, 1e9}) {
    weight = next;
    const auto rotation = Rotation<3>::exp({0.0, 0.0, heading});
    update.graph.pose_factors = {{0, 1, {Point<3>::UnitX(), rotation}, weight * PoseMatrix<3>::Identity()}};
    const AddedUpdate added = joined.add(update).value();
    EXPECT_TRUE(added.converged);
    EXPECT_EQ(added.batch_checked, heading == 0.0);  // only the first asks for it
    EXPECT_LT((joined.pose(PoseId{0, 1})->rotation.inverse() * rotation).log().norm(), 0.03);
    update.segments.clear();
    heading += 2.0 / 3.0 * std::numbers::pi;
  }
  const auto covariance = joined.covariance(PoseId{0, 1});
  ASSERT_TRUE(covariance);
  EXPECT_LT((weight * *covariance - PoseMatrix<3>::Identity()).norm(), 1e-6);
}

/// The second of three measurements turns the pose; the third is linearised there and outweighs both others.
TEST(IncrementalJoinInSpace, ACovarianceIsOfTheStepAtTheEstimate) {
  IncrementalJoin<3> joined;
  SubmapUpdate<3> update;
  update.poses = {{0, 0}, {0, 1}};
  update.segments = {{0, 1, false}};
  const PoseMatrix<3> information = (PoseVector<3>() << 1.0, 2.0, 3.0, 4.0, 25.0, 36.0).finished().asDiagonal();
  for (const auto& [weight, turn] : {std::pair{1e-12, 0.0}, {1e-6, 1.0}, {1.0, 1.0}}) {
    const auto rotation = Rotation<3>::exp(turn * Vector<3>(0.3, 0.5, 0.6));
    update.graph.pose_factors = {{0, 1, {Point<3>::UnitX(), rotation}, weight * information}};
    joined.add(update).value();
    update.segments.clear();
  }
  const auto covariance = joined.covariance(PoseId{0, 1});
  ASSERT_TRUE(covariance);
  EXPECT_LT((information * *covariance - PoseMatrix<3>::Identity()).norm(), 1e-4);
}

TYPED_TEST(IncrementalJoinTest, IsTheSameEveryTime) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 100, .features = 60, .closures = 6}, 6.0);
  IncrementalJoin<kDim> a, b;
  for (const auto& update : updates) {
    const AddedUpdate of_a = a.add(update).value();
    const AddedUpdate of_b = b.add(update).value();
    EXPECT_EQ(of_a.chi2, of_b.chi2);
    EXPECT_EQ(of_a.eliminated, of_b.eliminated);
    EXPECT_EQ(a.pose(last_pose(update))->translation, b.pose(last_pose(update))->translation);
  }
}

TYPED_TEST(IncrementalJoinTest, CovariancesAreTheInverseOfTheInformationAtTheEstimate) {
  constexpr int kDim = TestFixture::kDim;
  // Measurements without errors, so that every linearisation is at the estimate.
  const auto updates = this->submap_updates_of({.poses = 60, .features = 60, .closures = 6, .noise = 0.0}, 6.0);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  const SubmapSet<kDim> set = testing::set_of_all(updates);
  const Values<kDim> state = this->batch(updates).state;
  testing::DenseInformation<kDim> dense(state);
  for (const auto& map : set.graph.submaps) dense.add(map);
  for (const auto& o : set.graph.pose_factors) dense.add(o);
  const Eigen::MatrixXd inverse = dense.inverse({0});
  constexpr int kDof = kPoseDof<kDim>;
  for (const PoseIndex p : indices(set.poses)) {
    const auto row = dense.pose_row(p);
    const PoseMatrix<kDim> expected = inverse.block<kDof, kDof>(row, row);
    const auto covariance = joined.covariance(set.poses[p]);
    ASSERT_TRUE(covariance);
    EXPECT_LE((*covariance - expected).norm(), 1e-8 * expected.norm()) << p.value;
  }
  for (const FeatureIndex f : indices(set.features)) {
    const auto row = dense.feature_row(f);
    const PointMatrix<kDim> expected = inverse.block<kDim, kDim>(row, row);
    const auto covariance = joined.covariance(set.features[f]);
    ASSERT_TRUE(covariance);
    EXPECT_LE((*covariance - expected).norm(), 1e-8 * expected.norm()) << f.value;
  }
  EXPECT_EQ(joined.covariance(PoseId{0, 0}), (PoseMatrix<kDim>::Zero()));
  EXPECT_FALSE(joined.covariance(PoseId{0, 1000}) || joined.covariance(FeatureId{1000}));
}

TYPED_TEST(IncrementalJoinTest, CovariancesAreThoseOfARunInANoisyWorld) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = small_world<kDim>({.poses = 60, .features = 60, .closures = 6}).log;
  RunOptions options;
  options.split = {SplitRule::kPoses, 6.0};
  options.polish = false;
  options.covariances = options.marginals = true;
  const auto batch = run(log, options).value();
  IncrementalJoin<kDim> joined;
  for (const auto& update : testing::parts_of_log(log, 6.0)) joined.add(update).value();
  std::size_t kept = 0;
  for (const PoseIndex p : indices(log.poses)) {
    const auto covariance = joined.covariance(log.poses[p]);
    const auto& expected = batch.marginals->poses[p];
    if (!covariance) continue;
    EXPECT_LE((*covariance - expected).norm(), 0.02 * expected.norm()) << p.value;
    ++kept;
  }
  EXPECT_GE(kept, log.poses.size() / 6);
}

}  // namespace
}  // namespace mapjoin
