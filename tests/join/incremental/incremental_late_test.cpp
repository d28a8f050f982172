// SPDX-License-Identifier: BSD-3-Clause
// What comes late, of poses that local maps have eliminated.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mapjoin/join/incremental/robust_incremental_join.hpp>
#include <mapjoin/join/incremental/submap_update_maker.hpp>
#include <tests/join/incremental/incremental_join_fixture.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>

namespace mapjoin {
namespace {

template <typename D>
class IncrementalLateTest : public testing::IncrementalJoinFixture<D> {
 protected:
  static constexpr int kDim = D::value;
  using Parts = std::vector<SubmapUpdate<kDim>>;

  /// The log pose by pose, as a robot drives; closures, and what every third pose sees, come twenty poses late.
  static std::vector<Log<kDim>> late(const Log<kDim>& log) {
    std::map<PoseIndex, LogBuilder<kDim>> builders;
    const auto at = [&](PoseIndex pose, bool is_late) -> LogBuilder<kDim>& {
      return builders.try_emplace(PoseIndex(pose + (is_late ? 20 : 0)), "slice").first->second;
    };
    const auto id = [&](PoseIndex pose) { return log.poses[pose]; };
    for (const auto& o : log.odometry()) at(later_pose(o), false).add(id(o.base), id(o.target), o);
    for (const auto& o : log.closures()) at(later_pose(o), true).add(id(o.base), id(o.target), o);
    for (const auto& o : log.observations()) at(o.base, o.base.value % 3 == 2).add(id(o.base), log.features[o.target], o);
    std::vector<Log<kDim>> slices;
    for (auto& [pose, builder] : builders) slices.push_back(std::move(builder).finish().value());
    return slices;
  }

  /// Joins slices of a log as they come. Returns the number of maps that were made anew.
  template <typename Join>
  static std::size_t join_slices(const std::vector<Log<kDim>>& slices, Join& joined) {
    SubmapUpdateMaker<kDim> maker({SplitRule::kPoses, 6.0});
    std::size_t remade = 0;
    for (std::size_t k = 0; k < slices.size(); ++k) {
      EXPECT_TRUE(maker.add(slices[k])) << k;
      for (const auto& [number, map] : maker.take_remade()) {
        EXPECT_TRUE(joined.keep_more(number, map));
        ++remade;
      }
      Parts updates = maker.take(k + 1 == slices.size()).value();
      for (auto& update : updates) EXPECT_TRUE(joined.add(std::move(update)));
    }
    return remade;
  }

  /// The largest difference of a pose from a join of the whole log (m, rad).
  static double difference_from_whole(const IncrementalJoin<kDim>& joined, const Log<kDim>& log) {
    const Parts steps = testing::parts_of_log(log, 1.0);
    const SubmapSet<kDim> set = testing::set_of_all(steps);
    const Values<kDim> state = IncrementalLateTest::batch(steps).state;
    double difference = 0.0;
    for (const PoseIndex p : indices(set.poses)) {
      const Pose<kDim>* pose = joined.pose(set.poses[p]);
      if (pose) difference = std::max(difference, local(*pose, state.poses[p]).norm());
    }
    return difference;
  }

  static Parts all_of(const IncrementalJoin<kDim>& joined) {
    Parts updates;
    for (std::size_t k = 0; k < joined.update_count(); ++k) updates.push_back(joined.update(k));
    return updates;
  }
};
TYPED_TEST_SUITE(IncrementalLateTest, testing::Dimensions);

TYPED_TEST(IncrementalLateTest, OnlyMapsThatItConcernsAreMadeAnew) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = testing::small_world<kDim>({.poses = 120, .features = 80, .closures = 15}).log;
  IncrementalJoin<kDim> joined;
  const std::size_t remade = this->join_slices(this->late(log), joined);
  EXPECT_GT(remade, 20u);
  EXPECT_LT(remade, 80u);  // each eliminated pose that something late concerns, once
  EXPECT_EQ(joined.waiting(), 0u);
  const double optimum = this->batch(this->all_of(joined)).result.chi2;
  EXPECT_NEAR(joined.chi2(), optimum, 1e-3 * optimum);
  EXPECT_LT(this->difference_from_whole(joined, log), 0.03);
}

TYPED_TEST(IncrementalLateTest, ARobustJoinEndsAsTheOther) {
  constexpr int kDim = TestFixture::kDim;
  const auto slices = this->late(testing::small_world<kDim>({.poses = 90, .features = 60, .closures = 12}).log);
  IncrementalJoin<kDim> joined;
  RobustIncrementalJoin<kDim> robust;
  EXPECT_EQ(this->join_slices(slices, joined), this->join_slices(slices, robust));
  EXPECT_TRUE(robust.left_out().empty());
  EXPECT_NEAR(robust.estimate().chi2(), joined.chi2(), 2e-3 * joined.chi2());
  EXPECT_EQ(robust.estimate().dof(), joined.dof());
}

/// Maps of six poses, of which one is then replaced by one that keeps all of its poses.
TYPED_TEST(IncrementalLateTest, AMapThatKeepsMoreChangesNothing) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = testing::small_world<kDim>({.poses = 60, .features = 60, .closures = 0}).log;
  Split parts = split(log, {SplitRule::kPoses, 6.0});
  const auto updates = mapjoin::submap_updates_of(log, parts, build_local_maps<kDim>(log, parts, {}).value().maps);
  for (PoseIndex p = 12; p < 18; ++p) parts.kept[p] = true;
  const auto more = mapjoin::submap_updates_of(log, parts, build_local_maps<kDim>(log, parts, {}).value().maps);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  joined.rejoin();
  const double chi2 = joined.chi2();
  const std::int64_t dof = joined.dof();
  EXPECT_FALSE(joined.pose({0, 15}));
  const AddedUpdate kept = joined.keep_more(2, more[2]).value();
  EXPECT_TRUE(kept.is_joined);
  EXPECT_LT(kept.metres, 1e-3);
  EXPECT_NEAR(joined.chi2(), chi2, 1e-3 * chi2);
  EXPECT_EQ(joined.dof(), dof);
  EXPECT_TRUE(joined.covariance(PoseId{0, 15}));
  EXPECT_LT(this->difference(joined, more), 0.01);
}

TYPED_TEST(IncrementalLateTest, WhatIsNoMapOfTheSameSegmentIsRefusedByName) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = this->submap_updates_of({.poses = 30, .features = 40, .closures = 0}, 6.0);
  IncrementalJoin<kDim> joined;
  for (const auto& update : updates) joined.add(update).value();
  const auto message = [&](SubmapUpdate<kDim> map) {
    map.source = "map";
    return testing::error_of(joined.keep_more(1, map));
  };
  EXPECT_EQ(message(updates[2]), "map: the map is not of the segment from pose 6 to 12");
  SubmapUpdate<kDim> none = updates[1];
  none.segments.clear();
  none.graph.submaps.clear();
  EXPECT_EQ(message(none), "map: a local map can only take the place of another one");
  SubmapUpdate<kDim> other = updates[1];
  other.features[0] = {999};
  EXPECT_EQ(message(other), "map: " + to_string(updates[1].features[0]) + " was in the map, and is not any more");
  SubmapUpdate<kDim> more = updates[1];
  more.graph.fixed.push_back({0, {}});
  EXPECT_EQ(message(more),
            "map: only a local map can take the place of another one: give other factors in an update of their own");
  EXPECT_THROW((void)joined.keep_more(99, updates[1]), std::out_of_range);
}

TYPED_TEST(IncrementalLateTest, AFeatureIsEnteredWhereAKnownPoseSeesIt) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = this->submap_updates_of({.poses = 30, .features = 40, .closures = 0}, 6.0);
  SubmapUpdate<kDim> late;
  late.poses = {last_pose(updates[1])};
  late.features = {{999}};
  late.graph.feature_factors = {{0, 0, Point<kDim>::Ones(), PointMatrix<kDim>::Identity(), {}},
                                {0, 0, 2.0 * Point<kDim>::Ones(), PointMatrix<kDim>::Identity(), {}}};
  updates.push_back(late);
  IncrementalJoin<kDim> joined;
  AddedUpdate last;
  for (const auto& update : updates) last = joined.add(update).value();
  ASSERT_TRUE(last.is_joined);
  EXPECT_EQ(last.batch_checked, false);
  const Point<kDim> seen = transform_into(*joined.pose(late.poses[0]), *joined.feature({999}));
  EXPECT_LT((seen - 1.5 * Point<kDim>::Ones()).norm(), 1e-3);
  EXPECT_NEAR(last.chi2, this->batch(updates).result.chi2, 1e-3 * last.chi2);
  EXPECT_LT(this->difference(joined, updates), 0.01);
}

}  // namespace
}  // namespace mapjoin
