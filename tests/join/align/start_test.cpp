// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::largest_difference;
using testing::small_world;

template <typename D>
class StartTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  PartialMap<kDim> partial() const {
    PartialMap<kDim> partial;
    partial.state = world.truth;
    for (const PoseIndex p : indices(world.truth.poses)) partial.poses.push_back(p);
    for (const FeatureIndex f : indices(world.truth.features)) partial.features.push_back(f);
    return partial;
  }
  testing::SmallWorld<kDim> world = small_world<kDim>();
};
TYPED_TEST_SUITE(StartTest, testing::Dimensions);

TYPED_TEST(StartTest, ZeroIsZeroButForThePoseThatHoldsTheMap) {
  auto partial = this->partial();
  const auto first = retract<TestFixture::kDim>({}, PoseVector<TestFixture::kDim>::Ones());
  partial.state.poses[0] = first;
  set_to_zero(partial);
  EXPECT_EQ(partial.state.poses[0].translation, first.translation);
  for (PoseIndex p = 1; p < indices(partial.state.poses).last; ++p) {
    EXPECT_EQ(local(partial.state.poses[p], Pose<TestFixture::kDim>{}).norm(), 0.0);
  }
  for (const auto& feature : partial.state.features) EXPECT_EQ(feature.norm(), 0.0);
}

TYPED_TEST(StartTest, RandomValuesFillTheBoxOfTheComposedStart) {
  constexpr int kDim = TestFixture::kDim;
  auto partial = this->partial();
  Eigen::AlignedBox<double, kDim> box, drawn;
  for (const auto& pose : partial.state.poses) box.extend(pose.translation);
  for (const auto& feature : partial.state.features) box.extend(feature);
  set_to_random(7, partial);
  for (const auto& pose : partial.state.poses) drawn.extend(pose.translation);
  for (const auto& feature : partial.state.features) drawn.extend(feature);
  EXPECT_TRUE(box.contains(drawn));
  EXPECT_GT(drawn.sizes().minCoeff(), 0.7 * box.sizes().minCoeff());
}

TYPED_TEST(StartTest, OneSeedGivesOneStart) {
  auto once = this->partial();
  auto again = this->partial();
  auto another = this->partial();
  set_to_random(7, once);
  set_to_random(7, again);
  set_to_random(8, another);
  EXPECT_EQ(largest_difference(once.state, again.state), 0.0);
  EXPECT_GT(largest_difference(once.state, another.state), 1.0);
}

TYPED_TEST(StartTest, AScheduleThatNeedsNoStartTakesNone) {
  RunOptions options;
  options.start = Start::kZero;
  EXPECT_EQ(options.validate().size(), 1u);
  options.schedule = Schedule::kBatch;
  EXPECT_TRUE(options.validate().empty());
}

TYPED_TEST(StartTest, TheRelativeStateFindsTheOptimumFromZero) {
  constexpr int kDim = TestFixture::kDim;
  const auto optimum = run(this->world.log, RunOptions{});
  ASSERT_TRUE(optimum);
  RunOptions options;
  options.schedule = Schedule::kBatch;
  options.start = Start::kZero;
  options.state = JoinedState::kRelative;
  options.solver.method = Method::kGaussNewton;
  const auto result = solve<kDim>(this->world.log, options);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_NEAR(result->chi2, optimum->chi2, 1e-7 * optimum->chi2);
}

/// The submap graph of a log in segments of six steps.
template <int Dim>
SubmapGraph<Dim> graph_of(const Log<Dim>& log) {
  Split parts = split(log, {SplitRule::kPoses, 6.0});
  auto maps = build_local_maps(log, parts, {}).value().maps;
  return submap_graph_of(log, parts, std::move(maps));
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
