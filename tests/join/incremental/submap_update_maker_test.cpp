// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/incremental/submap_update_maker.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

/// A log in slices of `poses_at_once` poses, as it is written while the robot drives: each pose comes with its odometry, its
/// closures to earlier poses, its observations and its priors; priors of features come first.
template <int Dim>
std::vector<Log<Dim>> driven(const Log<Dim>& log, int poses_at_once) {
  std::vector<Log<Dim>> slices;
  const auto id = [&](PoseIndex pose) { return log.poses[pose]; };
  for (PoseIndex begin = 0; begin < indices(log.poses).last; begin += poses_at_once) {
    LogBuilder<Dim> builder("slice");
    const auto is_here = [&](PoseIndex pose) { return pose >= begin && pose < begin + poses_at_once; };
    for (const auto& o : log.edges()) {
      if (is_here(std::max(o.base, o.target))) builder.add_pose_edge(id(o.base), id(o.target), o.measured, o.information);
    }
    for (const auto& o : log.observations()) {
      if (is_here(o.base)) {
        builder.add_observation(id(o.base), log.features[o.target], o.measured, o.information);
      }
    }
    for (const auto& o : log.pose_priors()) {
      if (is_here(o.target)) builder.add_pose_prior(id(o.target), o.measured, o.information);
    }
    for (const auto& o : log.feature_priors()) {
      if (begin == 0) builder.add_feature_prior(log.features[o.target], o.measured, o.information);
    }
    auto slice = std::move(builder).finish();
    if (slice) slices.push_back(*std::move(slice));
  }
  return slices;
}

template <int Dim>
double chi2_of(const std::vector<SubmapUpdate<Dim>>& updates) {
  const SubmapSet<Dim> set = testing::set_of_all(updates);
  return join(submap_graph_of(set), set.poses, set.features, JoinOptions<Dim>{}).value().result.chi2;
}

template <typename D>
class SubmapUpdateMakerTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// All updates of a log that comes in slices; none if the maker refuses a slice.
  static std::vector<SubmapUpdate<kDim>> parts_of_slices(const std::vector<Log<kDim>>& slices, SubmapUpdateMaker<kDim>& maker) {
    std::vector<SubmapUpdate<kDim>> updates;
    for (std::size_t k = 0; k <= slices.size(); ++k) {
      if (k < slices.size() && !maker.add(slices[k])) return {};
      auto more = maker.take(k == slices.size()).value();
      std::move(more.begin(), more.end(), std::back_inserter(updates));
    }
    return updates;
  }
};
TYPED_TEST_SUITE(SubmapUpdateMakerTest, testing::Dimensions);

TYPED_TEST(SubmapUpdateMakerTest, ALogThatComesInSlicesHasThePartsOfTheWhole) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = testing::small_world<kDim>({.poses = 50, .closures = 0, .sessions = 2}).log;
  Split segments = split(log, {SplitRule::kPoses, 6.0});
  const auto maps = build_local_maps<kDim>(log, segments, {}).value().maps;
  const auto joined_map = submap_updates_of(log, segments, maps);
  for (const int at_once : {1, 4, 7, 200}) {
    SubmapUpdateMaker<kDim> maker({SplitRule::kPoses, 6.0});
    const auto updates = this->parts_of_slices(driven(log, at_once), maker);
    ASSERT_EQ(updates.size(), joined_map.size()) << at_once;
    for (std::size_t k = 0; k < updates.size(); ++k) EXPECT_EQ(updates[k].poses, joined_map[k].poses) << at_once;
    EXPECT_NEAR(chi2_of(updates), chi2_of(joined_map), 1e-6 * chi2_of(joined_map));
  }
}

/// Positions of every fourth pose, and of two features, one of which is seen late.
TYPED_TEST(SubmapUpdateMakerTest, PriorsComeWithTheirPosesAndFeatures) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = testing::small_world<kDim>({.poses = 50, .closures = 0});
  PoseMatrix<kDim> of_position = PoseMatrix<kDim>::Zero();
  of_position.template topLeftCorner<kDim, kDim>() = 100.0 * PointMatrix<kDim>::Identity();
  LogBuilder<kDim> builder("with priors");
  builder.append(world.log);
  testing::Random random(3);
  for (PoseIndex p = 0; p < indices(world.log.poses).last; p += 4) {
    const Point<kDim> fix = world.truth.poses[p].translation + random.template vector<kDim>(0.2);
    builder.add_pose_prior(world.log.poses[p], {fix, {}}, of_position);
  }
  for (const FeatureIndex f : {world.log.observations().front().target, world.log.observations().back().target}) {
    builder.add_feature_prior(world.log.features[f], world.truth.features[f], 100.0 * PointMatrix<kDim>::Identity());
  }
  const Log<kDim> log = std::move(builder).finish().value();
  const auto whole = testing::parts_of_log(log, 6.0);
  for (const int at_once : {1, 7, 200}) {
    SubmapUpdateMaker<kDim> maker({SplitRule::kPoses, 6.0});
    const auto updates = this->parts_of_slices(driven(log, at_once), maker);
    ASSERT_EQ(updates.size(), whole.size()) << at_once;
    for (std::size_t k = 0; k < updates.size(); ++k) {
      EXPECT_EQ(updates[k].graph.pose_factors.size(), whole[k].graph.pose_factors.size()) << at_once << ", " << k;
      EXPECT_EQ(updates[k].graph.feature_factors.size(), whole[k].graph.feature_factors.size()) << at_once << ", " << k;
    }
    EXPECT_NEAR(chi2_of(updates), chi2_of(whole), 1e-6 * chi2_of(whole)) << at_once;
    IncrementalJoin<kDim> joined;
    AddedUpdate last;
    for (const auto& update : updates) last = joined.add(update).value();
    EXPECT_TRUE(last.is_joined);
    EXPECT_LT(last.chi2, 1.01 * chi2_of(whole) + 0.5);
  }
}

TYPED_TEST(SubmapUpdateMakerTest, ASegmentIsTakenOnceTheNextStepIsThere) {
  constexpr int kDim = TestFixture::kDim;
  const auto slices = driven(testing::small_world<kDim>({.poses = 20, .closures = 0}).log, 1);
  SubmapUpdateMaker<kDim> maker({SplitRule::kPoses, 6.0});
  std::vector<std::uint64_t> ends;  // the last pose that is there when an update is taken
  for (std::size_t k = 0; k < slices.size(); ++k) {
    ASSERT_TRUE(maker.add(slices[k]));
    const auto updates = maker.take(false).value();
    for (const auto& update : updates) {
      EXPECT_EQ(last_pose(update).key, 6 * (ends.size() + 1));
      ends.push_back(slices[k].poses.back().key);
    }
  }
  EXPECT_EQ(ends, (std::vector<std::uint64_t>{7, 13, 19}));
}

TYPED_TEST(SubmapUpdateMakerTest, ChecksItsOptionsWhereTheyAreGiven) {
  using Maker = SubmapUpdateMaker<TypeParam::value>;
  EXPECT_THROW(Maker({SplitRule::kPoses, -3.0}), std::invalid_argument);
  EXPECT_THROW(Maker({SplitRule::kAuto, -3.0}), std::invalid_argument);
  MinimiseOptions solver;
  solver.max_iterations = -4;
  EXPECT_THROW(Maker({SplitRule::kPoses, 6.0}, solver), std::invalid_argument);
}

TYPED_TEST(SubmapUpdateMakerTest, MapsAreOfTenPosesWhereNothingElseIsAskedFor) {
  constexpr int kDim = TestFixture::kDim;
  SubmapUpdateMaker<kDim> maker({});
  const auto updates = this->parts_of_slices(driven(testing::small_world<kDim>({.poses = 31, .closures = 0}).log, 1), maker);
  ASSERT_EQ(updates.size(), 3u);
  for (std::size_t k = 0; k < updates.size(); ++k) EXPECT_EQ(last_pose(updates[k]).key, 10 * (k + 1));
}

TYPED_TEST(SubmapUpdateMakerTest, APoseGraphKeepsAllPosesForClosuresToCome) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = testing::small_world<kDim>({.poses = 50, .features = 0, .closures = 30}).log;
  SubmapUpdateMaker<kDim> maker({SplitRule::kPoses, 6.0});
  const auto updates = this->parts_of_slices(driven(log, 1), maker);
  ASSERT_EQ(updates.size(), 9u);
  std::size_t edges = 0;
  for (const auto& update : updates) {
    EXPECT_TRUE(update.graph.submaps.empty());
    edges += update.graph.pose_factors.size();
  }
  EXPECT_EQ(edges, log.edges().size());
}

TYPED_TEST(SubmapUpdateMakerTest, ClosuresKeepTheirLossesWhereverTheyLead) {
  constexpr int kDim = TestFixture::kDim;
  const Loss loss = Loss::truncated(1.0);
  auto slices = driven(testing::small_world<kDim>({.poses = 20, .features = 0, .closures = 0}).log, 10);
  const auto add_closure = [&](Log<kDim>& slice, std::uint64_t base, std::uint64_t target) {
    LogBuilder<kDim> builder("slice");
    builder.append(slice);
    builder.add(PoseId{0, base}, PoseId{0, target}, PoseFactor<kDim>{0, 0, {}, PoseMatrix<kDim>::Identity(), loss});
    slice = std::move(builder).finish().value();
  };
  ASSERT_EQ(slices.size(), 2u);
  add_closure(slices[0], 1, 4);
  add_closure(slices[1], 2, 18);
  SubmapUpdateMaker<kDim> maker({SplitRule::kPoses, 6.0});
  std::vector<PoseId> ends;
  for (const auto& update : this->parts_of_slices(slices, maker)) {
    for (const auto& o : update.graph.pose_factors) {
      if (o.loss == loss) ends.push_back(update.poses[o.target]);
    }
  }
  EXPECT_EQ(ends, (std::vector<PoseId>{{0, 4}, {0, 18}}));
}

TYPED_TEST(SubmapUpdateMakerTest, WhatConcernsAnEliminatedPoseMakesItsMapAnew) {
  constexpr int kDim = TestFixture::kDim;
  const auto slices = driven(testing::small_world<kDim>({.poses = 30, .closures = 0}).log, 30);
  SubmapUpdateMaker<kDim> maker({SplitRule::kPoses, 6.0});
  ASSERT_TRUE(maker.add(slices[0]));
  const auto updates = maker.take(false).value();
  ASSERT_EQ(updates.size(), 4u);
  const auto add_edge = [&](std::uint64_t base, std::uint64_t target) {
    LogBuilder<kDim> builder("edge");
    builder.add_pose_edge({0, base}, {0, target}, {}, PoseMatrix<kDim>::Identity());
    return maker.add(std::move(builder).finish().value());
  };
  const auto add_prior = [&](std::uint64_t pose) {
    LogBuilder<kDim> builder("prior");
    builder.add_pose_prior({0, pose}, {}, PoseMatrix<kDim>::Identity());
    return maker.add(std::move(builder).finish().value());
  };
  EXPECT_TRUE(add_edge(6, 29));   // a kept pose and an open one
  EXPECT_TRUE(add_edge(12, 18));  // kept ones
  EXPECT_TRUE(add_prior(12));
  EXPECT_TRUE(maker.take_remade().empty());
  EXPECT_TRUE(add_edge(29, 8));
  EXPECT_TRUE(add_prior(8));
  LogBuilder<kDim> late("sight");
  late.add_observation({0, 3}, {0}, Point<kDim>::Ones(), PointMatrix<kDim>::Identity());
  EXPECT_TRUE(maker.add(std::move(late).finish().value()));
  const auto remade = maker.take_remade();
  ASSERT_EQ(remade.size(), 2u);
  EXPECT_EQ(remade[0].update, 1u);
  EXPECT_EQ(remade[0].map.poses, (PoseIds{{0, 6}, {0, 8}, {0, 12}}));
  EXPECT_EQ(remade[0].map.features.size(), updates[1].features.size());
  EXPECT_EQ(remade[1].update, 0u);
  EXPECT_EQ(remade[1].map.poses, (PoseIds{{0, 0}, {0, 3}, {0, 6}}));
  EXPECT_TRUE(maker.take_remade().empty());
  const auto rest = maker.take(true).value();
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].graph.pose_factors.size(), 5u);
  EXPECT_EQ(rest[0].graph.feature_factors.size(), 1u);
}

TYPED_TEST(SubmapUpdateMakerTest, ANewPoseBeforeThoseOfUpdatesIsRefused) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = testing::small_world<kDim>({.poses = 30, .closures = 0}).log;
  LogBuilder<kDim> builder("without pose 3");
  for (const auto& o : log.odometry()) {
    if (o.base != 3 && o.target != 3) builder.add(log.poses[o.base], log.poses[o.target], o);
  }
  SubmapUpdateMaker<kDim> maker({SplitRule::kPoses, 6.0});
  ASSERT_TRUE(maker.add(std::move(builder).finish().value()));
  ASSERT_FALSE(maker.take(false).value().empty());
  LogBuilder<kDim> edge("edge");
  edge.add_pose_edge({0, 2}, {0, 3}, {}, PoseMatrix<kDim>::Identity());
  EXPECT_FALSE(maker.add(std::move(edge).finish().value()));
}

}  // namespace
}  // namespace mapjoin
