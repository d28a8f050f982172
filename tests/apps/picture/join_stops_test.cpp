// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <apps/picture/load.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin::apps {
namespace {

template <typename Dimension>
class JoinStopsTest : public ::testing::Test {};
TYPED_TEST_SUITE(JoinStopsTest, testing::Dimensions);

TYPED_TEST(JoinStopsTest, GrowMapByMapInTheFrameOfTheWholeMap) {
  constexpr int kDim = TypeParam::value;
  auto set = testing::small_submap_set(testing::small_world<kDim>({.poses = 60, .features = 40}).log, 6.0);
  const Pose<kDim> away{10.0 * Point<kDim>::Ones(), Rotation<kDim>::exp(RotationVector<kDim>::Constant(0.7))};
  set.graph.fixed.push_back({0, away});
  const GlobalMap<kDim> map = run(set, RunOptions{}).value().map;
  const auto stops = join_stops(submap_graph_of(set), map, nullptr, {});
  ASSERT_EQ(stops.size(), set.graph.submaps.size());
  for (std::size_t k = 0; k < stops.size(); ++k) {
    EXPECT_EQ(stops[k].maps, k + 1);
    ASSERT_EQ(stops[k].poses.size(), stops[k].state.poses.size());
    EXPECT_EQ(stops[k].poses.back(), set.segments[k].end);
    for (const PoseIndex p : indices(stops[k].poses)) {
      const Pose<kDim>& whole = map.poses[stops[k].poses[p]];
      EXPECT_LT((stops[k].state.poses[p].translation - whole.translation).norm(), 1.0) << "map " << k << ", pose " << p.value;
    }
    EXPECT_LT((stops[k].state.poses.front().translation - away.translation).norm(), 1e-9);
  }
}

TEST(JoinStops, AreAHundredAtMost) {
  const auto set = testing::small_submap_set(testing::small_world<2>({.poses = 400}).log, 3.0);
  ASSERT_GT(set.graph.submaps.size(), 110U);
  const auto stops = join_stops(submap_graph_of(set), run(set, RunOptions{}).value().map, nullptr, {});
  EXPECT_LE(stops.size(), 100U);
  EXPECT_GT(stops.size(), 50U);
  EXPECT_EQ(stops.back().maps, set.graph.submaps.size());
}

}  // namespace
}  // namespace mapjoin::apps
