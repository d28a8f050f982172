// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/incremental/submap_update.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/localmap/build.hpp>
#include <set>
#include <stdexcept>
#include <tests/support/batch_join.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class SubmapUpdateTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  SubmapUpdateTest() {
    world_.log.graph.fixed.push_back({3, world_.truth.poses[3]});
    world_.log.graph.feature_factors.push_back(
        {kWorld, 7, world_.truth.features[7], PointMatrix<kDim>(100.0 * PointMatrix<kDim>::Identity())});
    split_ = split(world_.log, {SplitRule::kPoses, 6.0});
    maps_ = build_local_maps<kDim>(world_.log, split_, {}).value().maps;
    parts_ = submap_updates_of(world_.log, split_, maps_);
  }

  testing::SmallWorld<kDim> world_ = testing::small_world<kDim>({.poses = 60, .closures = 12, .sessions = 2});
  Split split_;
  std::vector<LocalMap<kDim>> maps_;
  std::vector<SubmapUpdate<kDim>> parts_;
};
TYPED_TEST_SUITE(SubmapUpdateTest, testing::Dimensions);

TYPED_TEST(SubmapUpdateTest, NothingIsSaidOfWhatIsNotYetKnown) {
  std::set<FeatureId> known;
  for (const auto& update : this->parts_) {
    const auto name = [&](FeatureIndex feature) { return update.features[feature]; };
    for (const auto& map : update.graph.submaps) {
      for (const FeatureIndex f : map.features) known.insert(name(f));
    }
    for (const PoseId& id : update.poses) EXPECT_LE(id, last_pose(update));
    for (const auto& o : update.graph.feature_factors) {
      EXPECT_TRUE(o.base != kWorld || known.contains(name(o.target)));
      known.insert(name(o.target));
    }
  }
}

TYPED_TEST(SubmapUpdateTest, ASetComesApartIntoTheUpdatesItIsMadeOf) {
  const auto set = testing::set_of_all(this->parts_);
  const auto parts = submap_updates_of(set);
  ASSERT_EQ(parts.size(), this->parts_.size());
  const auto again = testing::set_of_all(parts);
  EXPECT_EQ(again.poses, set.poses);
  EXPECT_EQ(again.graph.fixed.size(), set.graph.fixed.size());
  EXPECT_EQ(again.graph.pose_factors.size(), set.graph.pose_factors.size());
  EXPECT_EQ(again.graph.feature_factors.size(), set.graph.feature_factors.size());
  for (const auto& part : parts) EXPECT_TRUE(check_update(part));
  const double optimum = testing::batch_chi2(this->parts_, this->parts_.size());
  EXPECT_NEAR(testing::batch_chi2(parts, parts.size()), optimum, 1e-6 * optimum);
}

TYPED_TEST(SubmapUpdateTest, MapsAndSegmentsThatDoNotBelongTogetherAreRefused) {
  constexpr int kDim = TestFixture::kDim;
  const auto& log = this->world_.log;
  const auto expect_refused = [&](const Split& parts, const std::vector<LocalMap<kDim>>& maps) {
    EXPECT_THROW(submap_updates_of(log, parts, maps), std::invalid_argument);
  };
  expect_refused(this->split_, {});
  expect_refused(Split{}, {});
  expect_refused(Split{{}, this->split_.kept, 0}, {});
  auto fewer = this->maps_;
  fewer.pop_back();
  expect_refused(this->split_, fewer);
  Split part = this->split_;  // of a log with closures to poses behind it
  part.segments.resize(1);
  expect_refused(part, {this->maps_.front()});

  SubmapSet<kDim> set = testing::set_of_all(this->parts_);
  set.segments.pop_back();
  EXPECT_THROW(submap_updates_of(set), std::invalid_argument);
}

TYPED_TEST(SubmapUpdateTest, ASetThatNamesWhatItDoesNotHaveIsRefused) {
  constexpr int kDim = TestFixture::kDim;
  const SubmapSet<kDim> sound = testing::set_of_all(this->parts_);
  auto of_no_feature = sound;
  of_no_feature.graph.submaps[0].features[0] = 1000000;
  EXPECT_THROW(submap_updates_of(of_no_feature), std::invalid_argument);
  auto of_no_pose = sound;
  of_no_pose.graph.pose_factors[0].target = -5;
  EXPECT_THROW(submap_updates_of(of_no_pose), std::invalid_argument);
}

TYPED_TEST(SubmapUpdateTest, AllUpdatesJoinAsTheirLogDoes) {
  constexpr int kDim = TestFixture::kDim;
  const auto& log = this->world_.log;
  const SubmapGraph<kDim> of_log = submap_graph_of(log, this->split_, this->maps_);
  const SubmapSet<kDim> set = testing::set_of_all(this->parts_);
  const SubmapGraph<kDim> of_parts = submap_graph_of(set);
  EXPECT_EQ(of_parts.segments.size(), of_log.segments.size());
  EXPECT_EQ(std::ranges::count(of_parts.is_local, true), std::ranges::count(of_log.is_local, true));
  const auto a = join(of_log, log.poses, log.features, JoinOptions<kDim>{});
  const auto b = join(of_parts, set.poses, set.features, JoinOptions<kDim>{});
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->result.chi2, b->result.chi2, 1e-9 * a->result.chi2);
  EXPECT_EQ(a->result.dof, b->result.dof);
  const IndexOf pose(log.poses);
  const IndexOf feature(log.features);
  ASSERT_EQ(set.poses.size(), a->poses.size());
  Values<kDim> same;
  for (const PoseId& id : set.poses) same.poses.push_back(a->state.pose(*pose(id)));
  for (const FeatureId& id : set.features) same.features.push_back(a->state.features[*feature(id)]);
  EXPECT_LT(testing::largest_difference(same, b->state), 1e-6);
}

TYPED_TEST(SubmapUpdateTest, WhatCannotBeJoinedIsSaid) {
  const auto error = [&](const auto& change) {
    auto update = this->parts_.back();
    update.source = "here";
    EXPECT_TRUE(check_update(update));
    change(update);
    const auto checked = check_update(update);
    return checked ? "no error" : checked.error().message;
  };
  const PoseMatrix<TestFixture::kDim> W = PoseMatrix<TestFixture::kDim>::Identity();
  EXPECT_THAT(error([&](auto& u) {
                u.graph.pose_factors.push_back({99, 99, {}, W});
              }),
              ::testing::MatchesRegex(
                  "here: pose factor [0-9]+, from index 99 to index 99, names a pose or feature that is not there"));
  EXPECT_EQ(error([&](auto& u) {
              u.graph.pose_factors.push_back({0, 1, {}, W, Loss::truncated(1.0)});
            }),
            "here: factors with a loss cannot be joined map by map");
}

TYPED_TEST(SubmapUpdateTest, ASegmentOfOnePoseStandsBeforeTheOneThatGoesOnFromIt) {
  constexpr int kDim = TestFixture::kDim;
  SubmapUpdate<kDim> there;
  there.poses = {{0, 5}};
  there.segments = {{0, 0, false}};
  auto on = there;
  on.poses.push_back({0, 6});
  on.segments = {{0, 1, false}};
  on.graph.pose_factors = {{0, 1, {}, PoseMatrix<kDim>::Identity()}};
  const auto again = there;
  for (const auto& updates : std::vector<std::vector<const SubmapUpdate<kDim>*>>{
           {&there, &on}, {&on, &there}, {&there, &on, &again}, {&on, &again, &there}}) {
    const SubmapSet<kDim> set = set_of(updates);
    EXPECT_EQ(set.poses, (PoseIds{{0, 5}, {0, 6}}));
    ASSERT_EQ(set.segments.size(), updates.size());
    for (std::size_t k = 0; k + 1 < updates.size(); ++k) EXPECT_EQ(set.segments[k], (Segment{0, 0, false}));
    EXPECT_EQ(set.segments.back(), (Segment{0, 1, false}));
  }
}

TYPED_TEST(SubmapUpdateTest, ASegmentIsComposedInTheFrameOfItsFirstPose) {
  constexpr int kDim = TestFixture::kDim;
  const IndexOf pose(this->world_.log.poses);
  const IndexOf feature(this->world_.log.features);
  for (const auto& update : this->parts_) {
    const PartialMap<kDim> partial = composed(update);
    EXPECT_EQ(partial.poses.front(), update.segments[0].begin);
    EXPECT_EQ(partial.poses.back(), update.segments[0].end);
    const auto true_pose = [&](PoseIndex p) { return this->world_.truth.pose(*pose(update.poses[p])); };
    const Pose<kDim> base = true_pose(update.segments[0].begin);
    for (const PoseIndex p : indices(partial.poses)) {
      EXPECT_LT(local(partial.state.poses[p], between(base, true_pose(partial.poses[p]))).norm(), 0.5);
    }
    for (const FeatureIndex f : indices(partial.features)) {
      const FeatureId& id = update.features[partial.features[f]];
      const Point<kDim> p_local = transform_into(base, this->world_.truth.features[*feature(id)]);
      EXPECT_LT((partial.state.features[f] - p_local).norm(), 0.5);
    }
  }
}

}  // namespace
}  // namespace mapjoin
