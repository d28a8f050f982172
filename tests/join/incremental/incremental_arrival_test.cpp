// SPDX-License-Identifier: BSD-3-Clause
// Updates in the order that they come: fixed poses, priors, robots that take turns; and updates that are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <tests/join/incremental/incremental_join_fixture.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

template <typename D>
class IncrementalArrivalTest : public testing::IncrementalJoinFixture<D> {};
TYPED_TEST_SUITE(IncrementalArrivalTest, testing::Dimensions);

TYPED_TEST(IncrementalArrivalTest, WhatIsNoUpdateOfClosuresCannotBeTakenOut) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 20, .features = 20}, 5.0);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  const std::vector<std::size_t> map{0};
  const std::vector<std::size_t> none{99};
  SubmapUpdate<kDim> fixes;
  fixes.poses = {last_pose(updates[0])};
  fixes.graph.fixed = {{0, Pose<kDim>{}}};
  EXPECT_TRUE(testing::error_of(joined.hold(fixes)).ends_with("can be left out"));
  SubmapUpdate<kDim> prior;  // which may be what holds the map
  prior.poses = {last_pose(updates[0])};
  prior.graph.pose_factors = {{kWorld, 0, {}, PoseMatrix<kDim>::Identity()}};
  EXPECT_TRUE(testing::error_of(joined.hold(prior)).ends_with("can be left out"));
  const std::vector<std::size_t> holds{joined.update_count()};
  joined.add(prior).value();
  EXPECT_THROW(joined.change(holds, {}), std::invalid_argument);
  EXPECT_THROW(joined.change(map, {}), std::invalid_argument);
  EXPECT_THROW(joined.change(none, {}), std::invalid_argument);
  EXPECT_THROW(joined.change({}, none), std::invalid_argument);
  EXPECT_THROW(IncrementalJoin<kDim>({Point<kDim>::Constant(std::nan("")), {}}), std::invalid_argument);
}

TYPED_TEST(IncrementalArrivalTest, AnUpdateThatSaysNothingMayComeInAndBeTakenOut) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 20, .features = 20}, 5.0);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  const double chi2 = joined.chi2();
  const std::int64_t dof = joined.dof();
  const std::vector<std::size_t> nothing{joined.hold({}).value()};
  EXPECT_TRUE(joined.change({}, nothing).is_joined);
  EXPECT_TRUE(joined.change(nothing, {}).is_joined);
  EXPECT_NEAR(joined.chi2(), chi2, 1e-3 * chi2);
  EXPECT_EQ(joined.dof(), dof);
}

TYPED_TEST(IncrementalArrivalTest, NamesOfWhichNothingIsSaidDoNotCount) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 20, .features = 20}, 5.0);
  IncrementalJoin<kDim> without;
  for (const auto& update : updates) without.add(update).value();
  IncrementalJoin<kDim> joined;
  for (auto& update : updates) {
    update.features.push_back({999});
    EXPECT_TRUE(joined.add(update).value().is_joined);
  }
  joined.rejoin();
  EXPECT_FALSE(joined.feature({999}));
  EXPECT_NEAR(joined.chi2(), without.chi2(), 1e-3 * without.chi2());
}

TYPED_TEST(IncrementalArrivalTest, AMapIsPlacedByTheEdgeThatFitsBest) {
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
  EXPECT_EQ(added.iterations, 1);  // the estimate was there already
  EXPECT_LT(local(compose(*joined.pose(last_pose(updates[0])), measured), *joined.pose(PoseId{1, 0})).norm(), 1e-6);
}

TYPED_TEST(IncrementalArrivalTest, WhatTheWorldSaysLaterMovesAllIntoItsFrame) {
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

TYPED_TEST(IncrementalArrivalTest, WhatTheWorldSaysCountsHoweverLittleChi2Tells) {
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
  EXPECT_FALSE(joined.add(again).value().batch_checked);  // the map is in the World's frame already
}

TYPED_TEST(IncrementalArrivalTest, FixedPosesMayComeOneByOne) {
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
  updates[4].graph.fixed = {{updates[4].segments[0].end, fix(last_pose(updates[4]))}};  // comes with its pose
  SubmapUpdate<kDim> later;                                                             // fixes a pose that is known already
  later.poses = {last_pose(updates[2])};
  later.graph.fixed = {{0, fix(last_pose(updates[2]))}};
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  EXPECT_EQ(local(*joined.pose(last_pose(updates[4])), fixed.at(last_pose(updates[4]))).norm(), 0.0);
  joined.add(later).value();
  for (const auto& [id, value] : fixed) EXPECT_EQ(local(*joined.pose(id), value).norm(), 0.0) << to_string(id);
  later.graph.fixed[0].value.translation.x() += 5.0;
  EXPECT_EQ(testing::error_of(joined.check(later)), to_string(later.poses[0]) + " is fixed elsewhere already");
}

TYPED_TEST(IncrementalArrivalTest, PriorsAndSingleObservationsMayComeByThemselves) {
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

/// Maps of three robots, whose turns are random.
TYPED_TEST(IncrementalArrivalTest, SeveralRobotsMayTakeTurns) {
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

TYPED_TEST(IncrementalArrivalTest, WhatDoesNotFollowIsRefusedByName) {
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
