// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

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

  /// The largest difference between the estimate and a join of all updates (m, rad).
  static double difference(const IncrementalJoin<kDim>& joined, const Join<kDim>& batch) {
    double largest = 0.0;
    for (const Index p : batch.poses) {
      if (!joined.pose(p)) return std::nan("");
      largest = std::max(largest, local(*joined.pose(p), batch.state.pose(p)).norm());
    }
    for (std::size_t f = 0; f < batch.state.features.size(); ++f) {
      const auto* feature = joined.feature(static_cast<Index>(f));
      if (!feature) return std::nan("");
      largest = std::max(largest, (*feature - batch.state.features[f]).norm());
    }
    return largest;
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
  for (const auto& update : updates) last = joined.add(update);
  const auto batch = this->batch(updates);
  // The difference of chi2 is that of the states in squared standard deviations, all of them together.
  EXPECT_NEAR(last.chi2, batch.result.chi2, 0.02);
  EXPECT_EQ(last.dof, batch.dof());
  EXPECT_LT(this->difference(joined, batch), 0.01);
}

TYPED_TEST(IncrementalJoinTest, JoinsSpansOfAPoseGraph) {
  const auto updates = this->submap_updates_of({.poses = 60, .features = 0, .closures = 40, .reversed_odometry = true}, 5.0);
  ASSERT_TRUE(std::any_of(updates.begin(), updates.end(), [](const auto& update) { return !update.map; }));
  testing::expect_optimal_at_every_kth_step(updates, 1);
}

TYPED_TEST(IncrementalJoinTest, SaysHowFarTheEstimateHasMoved) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 100, .features = 60, .closures = 6}, 6.0);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) {
    std::vector<std::pair<Index, Pose<kDim>>> before;
    for (Index p = 0; p < 100; ++p) {
      if (joined.pose(p)) before.emplace_back(p, *joined.pose(p));
    }
    const AddedUpdate added = joined.add(update);
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
  const auto second = static_cast<std::size_t>(
      std::find_if(updates.begin(), updates.end(), [](const auto& update) { return update.segment->begin == 60; }) -
      updates.begin());
  // Of the second session only its last update shares features with the first.
  auto cut = updates;
  Index next = 1000;
  for (std::size_t k = second; k + 1 < cut.size(); ++k) {
    for (Index& feature : cut[k].map->features) feature = next++;
  }
  IncrementalJoin<kDim> joined;
  for (std::size_t k = 0; k < cut.size(); ++k) {
    const bool ties = k + 1 == cut.size();
    const AddedUpdate added = joined.add(cut[k]);
    EXPECT_EQ(added.is_joined, k < second || ties) << k;
    EXPECT_EQ(joined.waiting(), k < second || ties ? 0 : k - second + 1);
    EXPECT_EQ(joined.pose(60) != nullptr, ties);
  }
  EXPECT_NEAR(joined.chi2(), this->batch(cut).result.chi2, 0.5);
}

TYPED_TEST(IncrementalJoinTest, WhatTheWorldSaysLaterMovesAllIntoItsFrame) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 60, .features = 60, .noise = 0.005}, 6.0);
  const Pose<kDim> place{Point<kDim>::Constant(5.0), Rotation<kDim>::exp(RotationVector<kDim>::Constant(0.4))};
  const Index pose = updates[4].segment->end;
  updates[4].fixed = {{pose, place}};
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update);
  EXPECT_EQ(local(*joined.pose(pose), place).norm(), 0.0);
  const auto batch = this->batch(updates);
  EXPECT_NEAR(joined.chi2(), batch.result.chi2, 0.5);
  EXPECT_LT(this->difference(joined, batch), 5e-3);
}

TYPED_TEST(IncrementalJoinTest, PriorsAndSingleObservationsMayComeByThemselves) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 60, .features = 60, .closures = 0, .noise = 0.005}, 6.0);
  SubmapUpdate<kDim> single;
  single.pose_factors.push_back(
      {updates[2].segment->begin, updates[5].segment->begin, Pose<kDim>{}, PoseMatrix<kDim>::Identity()});
  single.feature_factors.push_back({kWorld, updates[1].map->features[0], Point<kDim>::Ones(), PointMatrix<kDim>::Identity()});
  single.pose_factors.push_back({kWorld, 0, Pose<kDim>{}, PoseMatrix<kDim>::Identity()});
  updates.push_back(single);
  IncrementalJoin<kDim> joined;
  AddedUpdate last;
  for (const auto& update : updates) last = joined.add(update);
  EXPECT_TRUE(last.is_joined);
  EXPECT_GT(last.metres, 0.1);
  EXPECT_NEAR(last.chi2, this->batch(updates).result.chi2, 0.01 * last.chi2);
}

TYPED_TEST(IncrementalJoinTest, LooksAnewWhereOneMapInAThousandWouldFitAsBadly) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 60, .features = 60, .closures = 0}, 6.0);
  for (const auto& [probability, looks] : {std::pair{5e-4, true}, {2e-3, false}}) {
    IncrementalJoin<kDim> joined;
    AddedUpdate last;
    for (const auto& update : updates) last = joined.add(update);
    // A closure too weak to move anything, and off by as much as makes chi2 grow so improbably.
    const double scale = std::max(1.0, last.chi2 / static_cast<double>(last.dof));
    const double growth = scale * chi_squared_quantile(1.0 - probability, kPoseDof<kDim>);
    constexpr double kWeight = 1e-6;
    const Index base = updates[2].segment->begin;
    const Index target = updates[5].segment->begin;
    Pose<kDim> measured = between(*joined.pose(base), *joined.pose(target));
    measured.translation.x() += std::sqrt(growth / kWeight);
    SubmapUpdate<kDim> closure;
    closure.pose_factors.push_back({base, target, measured, PoseMatrix<kDim>(kWeight * PoseMatrix<kDim>::Identity())});
    const AddedUpdate added = joined.add(closure);
    EXPECT_NEAR(added.chi2 - last.chi2, growth, 0.02 * growth);
    EXPECT_EQ(added.batch_checked, looks);
    EXPECT_TRUE(added.converged);
  }
}

TYPED_TEST(IncrementalJoinTest, IsTheSameEveryTime) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 100, .features = 60, .closures = 6}, 6.0);
  IncrementalJoin<kDim> a, b;
  for (const auto& update : updates) {
    const AddedUpdate of_a = a.add(update);
    const AddedUpdate of_b = b.add(update);
    EXPECT_EQ(of_a.chi2, of_b.chi2);
    EXPECT_EQ(of_a.eliminated, of_b.eliminated);
    EXPECT_EQ(a.pose(update.segment->end)->translation, b.pose(update.segment->end)->translation);
  }
}

}  // namespace
}  // namespace mapjoin
