// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/align/joined_map.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

/// The submap graph of a log in segments of six steps.
template <int Dim>
SubmapGraph<Dim> graph_of(const Log<Dim>& log) {
  Split parts = split(log, {SplitRule::kPoses, 6.0});
  auto maps = build_local_maps(log, parts, {}).value().maps;
  return submap_graph_of(log, parts, std::move(maps));
}

/// The part of a state that a partial map has.
template <int Dim>
Values<Dim> restricted(const Values<Dim>& state, const PartialMap<Dim>& partial) {
  Values<Dim> part;
  for (const PoseIndex p : partial.poses) part.poses.push_back(state.pose(p));
  for (const FeatureIndex f : partial.features) part.features.push_back(state.features[f]);
  return part;
}

template <typename D>
class JoinedMapTest : public ::testing::Test {};
TYPED_TEST_SUITE(JoinedMapTest, testing::Dimensions);

TYPED_TEST(JoinedMapTest, HasAllThatTheMapsHaveNotMarginalised) {
  const auto world = testing::small_world<TypeParam::value>();
  const auto graph = graph_of(world.log);
  const auto joined_map = joined_map_of(graph);
  EXPECT_EQ(std::ssize(joined_map.poses), std::ranges::count(graph.is_joined, true));
  EXPECT_EQ(std::ssize(joined_map.features), std::ranges::count(graph.is_local, false));
  EXPECT_TRUE(std::ranges::all_of(joined_map.poses, [&](PoseIndex p) { return graph.is_joined[p]; }));
  EXPECT_TRUE(std::ranges::none_of(joined_map.features, [&](FeatureIndex f) { return graph.is_local[f]; }));
  EXPECT_EQ(joined_map.factors.submaps.size(), graph.maps.size());
  EXPECT_EQ(joined_map.factors.pose_factors, graph.factors.pose_factors);
}

TYPED_TEST(JoinedMapTest, IsComposedWithItsFirstPoseAtTheOrigin) {
  const auto world = testing::small_world<TypeParam::value>({.noise = 0.0});
  const auto graph = graph_of(world.log);
  const auto joined_map = joined_map_of(graph);
  const auto origin = testing::Random(3).pose<TypeParam::value>();
  const auto state = composed_state(graph, joined_map, origin, join_segments(graph, {}));
  EXPECT_LT(testing::largest_difference(state, restricted(moved(origin, world.truth), joined_map)), 1e-6);
}

TYPED_TEST(JoinedMapTest, IsComposedOfPartialMapsThatTheWorldAloneTies) {
  auto world = testing::small_world<TypeParam::value>({.features = 0, .sessions = 2, .noise = 0.0});
  const PoseIndex second(world.log.poses.size() / 2);
  world.log.graph.fixed = {{second, world.truth.pose(second)}};
  const auto graph = graph_of(world.log);
  const auto joined_map = joined_map_of(graph);
  auto joined = join_segments(graph, {});
  ASSERT_EQ(joined.partials.size(), 2U);
  const auto state = composed_state(graph, joined_map, world.truth.pose(0), std::move(joined));
  EXPECT_LT(testing::largest_difference(state, restricted(world.truth, joined_map)), 1e-6);
}

}  // namespace
}  // namespace mapjoin
