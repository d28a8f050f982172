// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/align/leaf.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

/// The leaves of a world measured without errors, one segment of which is raw.
template <typename D>
class LeavesTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr std::size_t kRaw = 2;

  LeavesTest() { make_raw(parts.segments[kRaw], parts); }
  /// The true state of a partial map, in the frame of its first pose.
  Values<kDim> truth_of(const PartialMap<kDim>& partial) const {
    const Pose<kDim>& frame = world.truth.pose(partial.poses.front());
    Values<kDim> state;
    for (const PoseIndex p : partial.poses) state.poses.push_back(between(frame, world.truth.pose(p)));
    for (const FeatureIndex f : partial.features) state.features.push_back(transform_into(frame, world.truth.features[f]));
    return state;
  }

  testing::SmallWorld<kDim> world = testing::small_world<kDim>({.noise = 0.0, .reversed_odometry = true});
  Split parts = split(world.log, {SplitRule::kPoses, 6.0});
};
TYPED_TEST_SUITE(LeavesTest, testing::Dimensions);

TYPED_TEST(LeavesTest, AreTheSegmentsInTheFrameOfTheirFirstPose) {
  const auto maps = build_local_maps(this->world.log, this->parts, {}).value().maps;
  const auto graph = submap_graph_of(this->world.log, this->parts, maps);
  const Leaves leaves(graph);
  for (std::size_t k = 0; k < graph.segments.size(); ++k) {
    const auto partial = leaves.partial(k);
    EXPECT_EQ(partial.poses.front(), graph.segments[k].begin);
    EXPECT_EQ(partial.poses.back(), graph.segments[k].end);
    EXPECT_EQ(partial.factors.submaps.size(), k == TestFixture::kRaw ? 0U : 1U);
    EXPECT_FALSE(partial.features.empty());
    EXPECT_LT(testing::largest_difference(partial.state, this->truth_of(partial)), 1e-6) << k;
  }
}

TYPED_TEST(LeavesTest, LeaveTheObservationsBetweenThemAsClosures) {
  const auto maps = build_local_maps(this->world.log, this->parts, {}).value().maps;
  const auto graph = submap_graph_of(this->world.log, this->parts, maps);
  const Leaves leaves(graph);
  const auto within = leaves.partial(TestFixture::kRaw).factors.pose_factors.size();
  EXPECT_EQ(within + leaves.closures().size(), graph.factors.pose_factors.size());
  EXPECT_FALSE(leaves.closures().empty());
  for (const auto* closure : leaves.closures()) {
    const auto [first, last] = leaves.segments_of(*closure);
    const auto [low, high] = std::minmax(closure->base, closure->target);
    EXPECT_LT(first, last);
    EXPECT_LE(graph.segments[first].begin, low);
    EXPECT_LT(low, graph.segments[first].end);
    EXPECT_LE(high, graph.segments[last].end);
  }
}

/// One of a feature that the map of a segment has, and one of another.
TYPED_TEST(LeavesTest, HaveWhatPosesOfMapsSeeBesides) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = build_local_maps(this->world.log, this->parts, {}).value().maps;
  auto graph = submap_graph_of(this->world.log, this->parts, maps);
  const PoseIndex base = graph.segments.front().begin;
  const FeatureIndex known = Leaves(graph).partial(0).features.front();
  const FeatureIndex other(graph.feature_count++);
  const FeatureFactor<kDim> again{base, known, Point<kDim>::Ones(), PointMatrix<kDim>::Identity(), {}};
  const FeatureFactor<kDim> first{base, other, Point<kDim>::Ones(), PointMatrix<kDim>::Identity(), {}};
  const Point<kDim> before = feature_in(Leaves(graph).partial(0), known);
  graph.factors.feature_factors.push_back(&again);
  graph.factors.feature_factors.push_back(&first);
  const auto partial = Leaves(graph).partial(0);
  EXPECT_EQ(partial.factors.feature_factors, (std::vector<const FeatureFactor<kDim>*>{&again, &first}));
  EXPECT_EQ(feature_in(partial, known), before);
  EXPECT_EQ(feature_in(partial, other), Point<kDim>(Point<kDim>::Ones()));
}

}  // namespace
}  // namespace mapjoin
