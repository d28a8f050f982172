// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <numbers>
#include <tests/support/batch_join.hpp>
#include <tests/support/dense_information.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <tuple>

namespace mapjoin {
namespace {

using testing::small_world;

template <typename D>
class IncrementalJoinTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  using Parts = std::vector<SubmapUpdate<kDim>>;

  static Parts submap_updates_of(const testing::WorldOptions& options, double poses_per_map) {
    return testing::parts_of_log(small_world<kDim>(options).log, poses_per_map);
  }

  static Join<kDim> batch(const Parts& updates) {
    std::vector<const SubmapUpdate<kDim>*> all;
    for (const auto& update : updates) all.push_back(&update);
    return testing::batch_join(all);
  }

  /// A closure between the first poses of two updates.
  static SubmapUpdate<kDim> closure(const SubmapUpdate<kDim>& from, const SubmapUpdate<kDim>& to, const Pose<kDim>& measured,
                                    const PoseMatrix<kDim>& information) {
    SubmapUpdate<kDim> closure;
    closure.poses = {first_pose(from), first_pose(to)};
    closure.graph.pose_factors = {{0, 1, measured, information}};
    return closure;
  }

  /// The largest difference between the estimate and a join of all updates (m, rad).
  static double difference(const IncrementalJoin<kDim>& joined, const Parts& updates) {
    const SubmapSet<kDim> set = testing::set_of_all(updates);
    const Values<kDim> state = batch(updates).state;
    Values<kDim> found;
    for (const PoseId& id : set.poses) found.poses.push_back(*joined.pose(id));
    for (const FeatureId& id : set.features) found.features.push_back(*joined.feature(id));
    return testing::largest_difference(found, state);
  }
};
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
  EXPECT_EQ(last.dof, batch.dof());
  EXPECT_LT(this->difference(joined, updates), 0.01);
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
    EXPECT_GE(added.metres, metres);  // that of a feature may be larger
    EXPECT_DOUBLE_EQ(added.radians, radians);
  }
}

TYPED_TEST(IncrementalJoinTest, ASessionThatSharesNothingYetWaits) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 60, .features = 60, .sessions = 2}, 6.0);
  const auto second = static_cast<std::size_t>(std::find_if(updates.begin(), updates.end(),
                                                            [](const auto& update) {
                                                              return first_pose(update) == PoseId{1, 0};
                                                            }) -
                                               updates.begin());
  // Of the second session only its last update shares features with the first.
  auto cut = updates;
  std::uint64_t next = 1000;
  for (std::size_t k = second; k + 1 < cut.size(); ++k) {
    for (FeatureId& feature : cut[k].features) feature = {next++};
  }
  IncrementalJoin<kDim> joined;
  for (std::size_t k = 0; k < cut.size(); ++k) {
    const bool ties = k + 1 == cut.size();
    const AddedUpdate added = joined.add(cut[k]).value();
    EXPECT_EQ(added.is_joined, k < second || ties) << k;
    if (k >= second) {
      EXPECT_EQ(added.batch_checked, ties) << k;
    }
    EXPECT_EQ(joined.waiting(), k < second || ties ? 0 : k - second + 1);
    EXPECT_EQ(joined.pose({1, 0}) != nullptr, ties);
  }
  EXPECT_NEAR(joined.chi2(), this->batch(cut).result.chi2, 0.5);
}

TYPED_TEST(IncrementalJoinTest, AnEdgeTiesASessionEitherWay) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 20, .features = 0, .closures = 0, .sessions = 2}, 5.0);
  const std::size_t half = updates.size() / 2;
  ASSERT_EQ(first_pose(updates[half]), (PoseId{1, 0}));
  const Pose<kDim> measured{Point<kDim>::Ones(), Rotation<kDim>::exp(RotationVector<kDim>::Constant(0.3))};
  for (const bool is_forward : {true, false}) {
    IncrementalJoin<kDim> joined;
    for (std::size_t k = 0; k < half; ++k) joined.add(updates[k]).value();
    auto tied = updates[half];
    const PoseIndex known = enter_name(tied.poses, last_pose(updates[0]));
    PoseFactor<kDim> edge{known, tied.segments[0].begin, measured, PoseMatrix<kDim>::Identity()};
    if (!is_forward) edge = {edge.target, edge.base, inverse(measured), edge.information};
    tied.graph.pose_factors.push_back(edge);
    const AddedUpdate added = joined.add(tied).value();
    EXPECT_TRUE(added.is_joined);
    EXPECT_FALSE(added.batch_checked);
    EXPECT_LT(local(compose(*joined.pose(last_pose(updates[0])), measured), *joined.pose(PoseId{1, 0})).norm(), 1e-6);
  }
}

TYPED_TEST(IncrementalJoinTest, AMapIsPlacedByTheEdgeThatFitsBest) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 20, .features = 0, .closures = 0, .sessions = 2}, 5.0);
  const std::size_t half = updates.size() / 2;
  IncrementalJoin<kDim> joined;
  for (std::size_t k = 0; k < half; ++k) joined.add(updates[k]).value();
  auto tied = updates[half];
  const PoseIndex known = enter_name(tied.poses, last_pose(updates[0]));
  const Pose<kDim> measured{Point<kDim>::Ones(), Rotation<kDim>::exp(RotationVector<kDim>::Constant(0.3))};
  const Pose<kDim> turned = compose(measured, {Point<kDim>::Zero(), Rotation<kDim>::exp(RotationVector<kDim>::Constant(1.5))});
  for (const auto& [edge, weight] : {std::pair{turned, 1e-6}, {measured, 1e4}}) {
    tied.graph.pose_factors.push_back({known, tied.segments[0].begin, edge, weight * PoseMatrix<kDim>::Identity()});
  }
  const AddedUpdate added = joined.add(tied).value();
  EXPECT_TRUE(added.converged);
  EXPECT_FALSE(added.batch_checked);
  EXPECT_EQ(added.iterations, 1);  // it was there
  EXPECT_LT(local(compose(*joined.pose(last_pose(updates[0])), measured), *joined.pose(PoseId{1, 0})).norm(), 1e-6);
}

TYPED_TEST(IncrementalJoinTest, WhatTheWorldSaysLaterMovesAllIntoItsFrame) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 60, .features = 60, .noise = 0.005}, 6.0);
  const Pose<kDim> place{Point<kDim>::Constant(5.0), Rotation<kDim>::exp(RotationVector<kDim>::Constant(0.4))};
  const PoseId pose = last_pose(updates[4]);
  updates[4].graph.fixed = {{updates[4].segments[0].end, place}};
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  EXPECT_EQ(local(*joined.pose(pose), place).norm(), 0.0);
  const auto batch = this->batch(updates);
  EXPECT_NEAR(joined.chi2(), batch.result.chi2, 0.5);
  EXPECT_LT(this->difference(joined, updates), 5e-3);
}

TYPED_TEST(IncrementalJoinTest, WhatTheWorldSaysCountsHoweverLittleChi2Tells) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 60, .features = 60, .noise = 0.005}, 6.0);
  const Pose<kDim> place{Point<kDim>::Constant(50.0), Rotation<kDim>::exp(RotationVector<kDim>::Constant(0.4))};
  const PoseFactor<kDim> prior{kWorld, updates[4].segments[0].end, place, 1e-6 * PoseMatrix<kDim>::Identity()};
  updates[4].graph.pose_factors.push_back(prior);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  EXPECT_LT(local(*joined.pose(last_pose(updates[4])), place).norm(), 1e-3);
  SubmapUpdate<kDim> again;
  again.poses = {last_pose(updates[4])};
  again.graph.pose_factors = {{kWorld, 0, place, prior.information}};
  EXPECT_FALSE(joined.add(again).value().batch_checked);  // the frame is the World's already
}

TYPED_TEST(IncrementalJoinTest, FixedPosesMayComeOneByOne) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 60, .features = 60, .noise = 0.005}, 6.0);
  const auto estimate = this->batch(updates);
  const SubmapSet<kDim> set = testing::set_of_all(updates);
  std::map<PoseId, Pose<kDim>> fixed;
  const auto fix = [&](const PoseId& id) {
    const PoseIndex p(std::ranges::find(set.poses, id) - set.poses.begin());
    Pose<kDim> value = estimate.state.poses[p];
    value.translation.x() += 0.01;
    return fixed[id] = value;
  };
  updates[0].graph.fixed = {{0, fix(first_pose(updates[0]))}};
  updates[4].graph.fixed = {{updates[4].segments[0].end, fix(last_pose(updates[4]))}};  // with the pose
  SubmapUpdate<kDim> later;                                                             // and of one that is known
  later.poses = {last_pose(updates[2])};
  later.graph.fixed = {{0, fix(last_pose(updates[2]))}};
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  EXPECT_EQ(local(*joined.pose(last_pose(updates[4])), fixed.at(last_pose(updates[4]))).norm(), 0.0);
  joined.add(later).value();
  for (const auto& [id, value] : fixed) EXPECT_EQ(local(*joined.pose(id), value).norm(), 0.0) << to_string(id);
}

TYPED_TEST(IncrementalJoinTest, AClosureToWhatStillWaitsTiesIt) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 20, .features = 0, .closures = 0, .sessions = 2}, 5.0);
  const std::size_t half = updates.size() / 2;
  IncrementalJoin<kDim> joined;
  for (std::size_t k = 0; k <= half; ++k) EXPECT_EQ(joined.add(updates[k]).value().is_joined, k < half);
  const auto tie = this->closure(updates[0], updates[half], {}, PoseMatrix<kDim>::Identity());
  EXPECT_TRUE(joined.add(tie).value().is_joined);
  EXPECT_EQ(joined.waiting(), 0u);
  EXPECT_TRUE(joined.pose(PoseId{1, 0}));
}

TYPED_TEST(IncrementalJoinTest, PriorsAndSingleObservationsMayComeByThemselves) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 60, .features = 60, .closures = 0, .noise = 0.005}, 6.0);
  SubmapUpdate<kDim> single = this->closure(updates[2], updates[5], {}, PoseMatrix<kDim>::Identity());
  single.features = {updates[1].features[0]};
  single.graph.feature_factors.push_back({kWorld, 0, Point<kDim>::Ones(), PointMatrix<kDim>::Identity()});
  const PoseIndex first = enter_name(single.poses, first_pose(updates[0]));
  single.graph.pose_factors.push_back({kWorld, first, Pose<kDim>{}, PoseMatrix<kDim>::Identity()});
  updates.push_back(single);
  IncrementalJoin<kDim> joined;
  AddedUpdate last;
  for (const auto& update : updates) last = joined.add(update).value();
  EXPECT_TRUE(last.is_joined);
  EXPECT_GT(last.metres, 0.1);
  EXPECT_NEAR(last.chi2, this->batch(updates).result.chi2, 0.01 * last.chi2);
}

TYPED_TEST(IncrementalJoinTest, LooksAnewWhereOneMapInAThousandWouldFitAsBadly) {
  constexpr int kDim = TestFixture::kDim;
  const auto as_given = this->submap_updates_of({.poses = 60, .features = 60, .closures = 0}, 6.0);
  auto too_certain = as_given;  // the fit so far, not the covariances, says what is probable
  for (auto& update : too_certain) {
    for (auto& map : update.graph.submaps) map.information *= 1e4;
  }
  for (const auto& [updates, probability, looks] :
       {std::tuple{as_given, 5e-4, true}, {as_given, 2e-3, false}, {too_certain, 5e-4, true}, {too_certain, 2e-3, false}}) {
    IncrementalJoin<kDim> joined;
    AddedUpdate last;
    for (const auto& update : updates) last = joined.add(update).value();
    // A closure too weak to move anything, and off by as much as makes chi2 grow so improbably.
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

/// By measurements of one pose from another, each of which outweighs all before. At a whole turn from what its step refers to,
/// a rotation vector determines nothing any more.
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

/// The second measurement turns the pose, the third is linearised there and outweighs both.
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
  // Nothing was measured wrongly: every linearisation is at the estimate.
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
  for (const PoseIndex p : indices(log.poses)) {
    const auto covariance = joined.covariance(log.poses[p]);
    const auto& expected = batch.marginals->poses[p];
    if (covariance) {
      EXPECT_LE((*covariance - expected).norm(), 0.02 * expected.norm()) << p.value;
    }
  }
}

/// Whichever of three robots has its next map first.
TYPED_TEST(IncrementalJoinTest, SeveralRobotsMayTakeTurns) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 60, .features = 60, .sessions = 3}, 6.0);
  std::map<std::uint32_t, std::deque<SubmapUpdate<kDim>>> robots;
  for (const auto& update : updates) robots[last_pose(update).session].push_back(update);
  ASSERT_EQ(robots.size(), 3u);
  testing::Random random(3);
  typename TestFixture::Parts arrived;
  IncrementalJoin<kDim> joined;
  while (!robots.empty()) {
    const auto turn =
        std::next(robots.begin(), static_cast<std::ptrdiff_t>(random.uniform(0.0, 0.999) * static_cast<double>(robots.size())));
    arrived.push_back(turn->second.front());
    joined.add(arrived.back()).value();
    turn->second.pop_front();
    if (turn->second.empty()) robots.erase(turn);
  }
  EXPECT_EQ(joined.waiting(), 0u);
  const double optimum = this->batch(arrived).result.chi2;
  EXPECT_NEAR(joined.chi2(), optimum, 1e-3 * optimum);
  EXPECT_LT(this->difference(joined, arrived), 0.01);
}

TYPED_TEST(IncrementalJoinTest, WhatDoesNotFollowIsRefusedByName) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 30, .features = 40, .closures = 0}, 6.0);
  IncrementalJoin<kDim> joined;
  joined.add(updates[0]).value();
  joined.add(updates[1]).value();
  const auto message = [&](const SubmapUpdate<kDim>& update) {
    const auto added = joined.add(update);
    return added ? std::string() : added.error().message;
  };
  EXPECT_EQ(message(updates[1]),
            "update 3: pose 6 is in a segment already, which does not end there or goes on in another one");
  auto twice = updates[2];
  twice.poses.back() = {0, 0};
  EXPECT_EQ(message(twice), "update 3: pose 0 is in a segment already");
  EXPECT_EQ(message(this->closure(updates[0], updates[3], {}, PoseMatrix<kDim>::Identity())),
            "update 3: pose 18 is in no segment yet");
  auto broken = updates[2];
  broken.graph.submaps[0].feature_estimates[0].x() = std::nan("");
  EXPECT_EQ(message(broken), "update 3: local map 1 has an estimate that is not finite, or no rotation");
  broken = updates[2];
  broken.features[1] = broken.features[0];
  EXPECT_EQ(message(broken), "update 3: it names " + to_string(broken.features[0]) + " twice");
  broken = updates[2];
  broken.segments[0].is_map = false;
  EXPECT_EQ(message(broken), "update 3: its local map is not of the poses of its one segment, in their order");
  EXPECT_EQ(message(updates[2]), "");
}

}  // namespace
}  // namespace mapjoin
