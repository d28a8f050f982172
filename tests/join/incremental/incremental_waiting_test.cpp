// SPDX-License-Identifier: BSD-3-Clause
// Updates that wait until something ties them to the estimate, and what ties them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <tests/join/incremental/incremental_join_fixture.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

template <typename D>
class IncrementalWaitingTest : public testing::IncrementalJoinFixture<D> {};
TYPED_TEST_SUITE(IncrementalWaitingTest, testing::Dimensions);

TYPED_TEST(IncrementalWaitingTest, ASessionThatSharesNothingYetWaits) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 60, .features = 60, .sessions = 2}, 6.0);
  const auto second = static_cast<std::size_t>(std::find_if(updates.begin(), updates.end(),
                                                            [](const auto& update) {
                                                              return first_pose(update) == PoseId{1, 0};
                                                            }) -
                                               updates.begin());
  // The last update of the second session is the only one that shares features with the first.
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
    EXPECT_EQ(added.chi2, joined.chi2()) << "of what is joined, whatever waits";
    EXPECT_EQ(added.dof, joined.dof());
  }
  EXPECT_NEAR(joined.chi2(), this->batch(cut).result.chi2, 0.5);
}

/// Two poses that nothing relates.
template <int Dim>
SubmapUpdate<Dim> unrelated_poses() {
  SubmapUpdate<Dim> update;
  update.poses = {{9, 0}, {9, 1}};
  update.segments = {{0, 1, false}};
  return update;
}

TYPED_TEST(IncrementalWaitingTest, WhatCannotBeDeterminedKeepsNothingElseWaiting) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 20, .features = 20}, 5.0);
  const SubmapUpdate<kDim> free = unrelated_poses<kDim>();
  IncrementalJoin<kDim> joined;
  EXPECT_FALSE(joined.add(free).value().is_joined);
  for (const auto& update : updates) EXPECT_TRUE(joined.add(update).value().is_joined);
  IncrementalJoin<kDim> at_once;
  std::vector<SubmapUpdate<kDim>> all = updates;
  all.insert(all.begin(), free);
  at_once.add_all(all).value();
  for (const IncrementalJoin<kDim>* join : {&joined, &at_once}) {
    EXPECT_EQ(join->waiting(), 1U);
    EXPECT_LT(this->difference(*join, updates), 1e-3);
  }
}

/// A local map of one step.
template <int Dim>
SubmapUpdate<Dim> step_between(std::uint64_t from, std::uint64_t to, const PoseMatrix<Dim>& information) {
  SubmapUpdate<Dim> update;
  update.poses = {{0, from}, {0, to}};
  update.segments = {{0, 1, true}};
  Pose<Dim> ahead;
  ahead.translation[0] = 1.0;
  update.graph.submaps = {{0, {1}, {}, {ahead}, {}, information}};
  return update;
}

TYPED_TEST(IncrementalWaitingTest, WhatATiedMapLeavesFreeStaysUntilAnotherUpdateDeterminesIt) {
  constexpr int kDim = TestFixture::kDim;
  const PoseMatrix<kDim> certain = PoseMatrix<kDim>::Identity();
  PoseMatrix<kDim> singular = certain;
  singular(0, 0) = 0.0;
  for (const PoseMatrix<kDim>& information : {singular, PoseMatrix<kDim>(PoseMatrix<kDim>::Zero())}) {
    IncrementalJoin<kDim> joined;
    EXPECT_FALSE(IncrementalJoin<kDim>().add(step_between<kDim>(0, 1, information)).value().is_joined);
    EXPECT_TRUE(joined.add(step_between<kDim>(0, 1, certain)).value().is_joined);
    const AddedUpdate added = joined.add(step_between<kDim>(1, 2, information)).value();
    EXPECT_TRUE(added.is_joined && added.converged);
    EXPECT_LT(added.dof, 0);
    EXPECT_FALSE(joined.covariance(PoseId{0, 2}));
    Pose<kDim> ahead;
    ahead.translation[0] = 2.0;
    EXPECT_LT(local(*joined.pose({0, 2}), ahead).norm(), 1e-12);

    SubmapUpdate<kDim> closure;
    closure.poses = {{0, 0}, {0, 2}};
    ahead.translation[0] = 2.5;
    closure.graph.pose_factors = {{0, 1, ahead, certain}};
    EXPECT_GE(joined.add(closure).value().dof, 0);
    EXPECT_LT(local(*joined.pose({0, 2}), ahead).norm(), 1e-6);
    EXPECT_TRUE(joined.covariance(PoseId{0, 2}));
  }
}

TYPED_TEST(IncrementalWaitingTest, AnEarlierUpdateThatIsTiedLaterTakesTheFrame) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 20, .features = 20}, 5.0);
  const SubmapUpdate<kDim> free = unrelated_poses<kDim>();
  IncrementalJoin<kDim> joined;
  EXPECT_FALSE(joined.add(free).value().is_joined);
  for (const auto& update : updates) joined.add(update).value();
  const PoseId first = first_pose(updates[0]);
  EXPECT_LT(local(*joined.pose(first), Pose<kDim>{}).norm(), 1e-9);
  testing::Random random(2);
  SubmapUpdate<kDim> ties;
  ties.poses = {first, {9, 0}, {9, 1}};
  for (const PoseIndex p : {PoseIndex(1), PoseIndex(2)})
    ties.graph.pose_factors.push_back({0, p, random.pose<kDim>(), PoseMatrix<kDim>::Identity()});
  EXPECT_TRUE(joined.add(ties).value().is_joined);
  EXPECT_EQ(joined.waiting(), 0U);
  EXPECT_LT(local(*joined.pose({9, 0}), Pose<kDim>{}).norm(), 1e-9);
  for (const PoseIndex p : {PoseIndex(1), PoseIndex(2)}) {
    const Pose<kDim> relative = compose(inverse(*joined.pose(first)), *joined.pose(ties.poses[p]));
    EXPECT_LT(local(ties.graph.pose_factors[static_cast<std::size_t>(p.value) - 1].measured, relative).norm(), 1e-3);
  }
}

TYPED_TEST(IncrementalWaitingTest, WhatIsTakenOutKeepsNothingElseWaiting) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 20, .features = 0, .closures = 0, .sessions = 2}, 5.0);
  const std::size_t half = updates.size() / 2;
  ASSERT_EQ(first_pose(updates[half]), (PoseId{1, 0}));
  IncrementalJoin<kDim> joined;
  for (std::size_t k = 0; k < half; ++k) joined.add(updates[k]).value();
  EXPECT_FALSE(joined.add(unrelated_poses<kDim>()).value().is_joined);
  // Edges from many poses to one of the two, which leave the other one free.
  SubmapUpdate<kDim> in_vain;
  in_vain.poses.push_back({9, 0});
  for (std::size_t k = 0; k < half; ++k) {
    in_vain.graph.pose_factors.push_back(
        {enter_name(in_vain.poses, first_pose(updates[k])), 0, {}, PoseMatrix<kDim>::Identity()});
  }
  EXPECT_FALSE(joined.add(in_vain).value().is_joined);
  joined.change(std::array{half + 1}, {});
  EXPECT_FALSE(joined.add(updates[half]).value().is_joined);
  EXPECT_TRUE(joined.add(this->closure(updates[0], updates[half], {}, PoseMatrix<kDim>::Identity())).value().is_joined);
  EXPECT_EQ(joined.waiting(), 1U);
}

TYPED_TEST(IncrementalWaitingTest, AnEdgeTiesASessionEitherWay) {
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

TYPED_TEST(IncrementalWaitingTest, AClosureToWhatStillWaitsTiesIt) {
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

TYPED_TEST(IncrementalWaitingTest, WhatOnlyOneClosureTiedWaitsAgainWhenThatIsTakenOut) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 20, .features = 0, .closures = 4, .sessions = 2}, 5.0);
  const std::size_t half = updates.size() / 2;
  const auto tie = [&](double turn) {
    const Pose<kDim> measured{Point<kDim>::Ones(), Rotation<kDim>::exp(RotationVector<kDim>::Constant(turn))};
    return this->closure(updates[0], updates[half], measured, PoseMatrix<kDim>::Identity());
  };
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  joined.add({}).value();  // one that says nothing is of no part
  const std::vector<std::size_t> wrong{joined.update_count()};
  EXPECT_TRUE(joined.add(tie(1.0)).value().is_joined);
  ASSERT_TRUE(joined.pose(PoseId{1, 0}));
  const AddedUpdate out = joined.change(wrong, {});
  EXPECT_TRUE(out.converged);
  EXPECT_FALSE(out.is_joined);
  EXPECT_EQ(joined.waiting(), updates.size() - half);
  EXPECT_FALSE(joined.pose(PoseId{1, 0}));
  EXPECT_TRUE(joined.covariance(last_pose(updates[half - 1])));
  updates.push_back(tie(0.3));
  EXPECT_TRUE(joined.add(updates.back()).value().is_joined);
  IncrementalJoin<kDim> fresh;
  for (const auto& update : updates) fresh.add(update).value();
  EXPECT_NEAR(joined.chi2(), fresh.chi2(), 1e-3 * fresh.chi2());
  EXPECT_EQ(joined.dof(), fresh.dof());
  EXPECT_LT(this->difference(joined, updates), 1e-3);
}

}  // namespace
}  // namespace mapjoin
