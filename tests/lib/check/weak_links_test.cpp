// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/check/ties.hpp>
#include <mapjoin/check/weak_links.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <random>
#include <set>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin::testing {
namespace {

using Edges = std::vector<std::pair<std::uint64_t, std::uint64_t>>;

Log<2> log_of(const Edges& pose_edges, const Edges& observations = {}) {
  LogBuilder<2> builder("some.g2o");
  for (const auto& [a, b] : pose_edges) builder.add_pose_edge({0, a}, {0, b}, {}, Matrix<3>::Identity());
  for (const auto& [pose, f] : observations) builder.add_observation({0, pose}, {f}, Point<2>(1, 0), Matrix<2>::Identity());
  return std::move(builder).finish().value();
}

std::vector<std::vector<std::size_t>> chains_of(const Log<2>& log) {
  std::vector<std::vector<std::size_t>> chains;
  for (const LoneChain& chain : weak_links(log).chains) chains.push_back({chain.first - 1, chain.last - 1, chain.edges});
  return chains;
}

using Chains = std::vector<std::vector<std::size_t>>;

TEST(WeakLinks, AreWhatAloneHoldsTwoCyclesTogether) {
  EXPECT_EQ(chains_of(log_of({{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 5}, {5, 3}})), (Chains{{2, 3, 1}}));
}

TEST(WeakLinks, InARowAreOneChain) {
  const Edges two_cycles = {{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 5}, {5, 6}, {6, 7}, {7, 5}};
  EXPECT_EQ(chains_of(log_of(two_cycles)), (Chains{{2, 5, 3}}));
}

TEST(WeakLinks, PartAtACycleInBetween) {
  const Edges edges = {{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 5}, {5, 3}, {5, 6}, {6, 7}, {7, 8}, {8, 6}};
  EXPECT_EQ(chains_of(log_of(edges)), (Chains{{2, 3, 1}, {5, 6, 1}}));
}

TEST(WeakLinks, AreNotTheEndsOfAWay) {
  EXPECT_TRUE(chains_of(log_of({{0, 1}, {1, 2}, {2, 3}})).empty());
  EXPECT_TRUE(chains_of(log_of({{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}})).empty());
}

TEST(WeakLinks, AreConfirmedByASecondMeasurement) {
  EXPECT_TRUE(chains_of(log_of({{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 2}, {3, 4}, {4, 5}, {5, 3}})).empty());
}

TEST(WeakLinks, AreConfirmedByAFeatureSeenFromBothSides) {
  const Edges edges = {{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 5}, {5, 3}};
  EXPECT_TRUE(chains_of(log_of(edges, {{2, 7}, {3, 7}})).empty());
}

TEST(WeakLinks, AreFeaturesWithoutWhichPosesFallApart) {
  // Two rounds without odometry between them: feature 7 alone is seen from both; feature 8 is seen once.
  const Log<2> log = log_of({{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}}, {{1, 7}, {2, 7}, {3, 7}, {4, 7}, {4, 8}});
  const WeakLinks links = weak_links(log);
  EXPECT_THAT(links.features, ::testing::ElementsAre(vertices_of(log).feature(0)));
  EXPECT_TRUE(links.chains.empty());
}

/// True if the edge is all that connects two parts with a cycle in each (at least as many edges as vertices).
bool parts_cycles(const std::set<std::pair<std::uint64_t, std::uint64_t>>& edges,
                  const std::pair<std::uint64_t, std::uint64_t>& lone) {
  constexpr std::size_t kPoses = 30;
  std::vector<Edge> others;
  for (const auto& edge : edges) {
    if (edge != lone) others.emplace_back(edge.first, edge.second);
  }
  const std::vector<std::uint32_t> component = components_of(make_graph(kPoses, others));
  const auto has_cycle = [&](std::uint32_t part) {
    const auto is_inside = [&](const Edge& edge) { return component[edge.first] == part; };
    return std::count_if(others.begin(), others.end(), is_inside) >= std::count(component.begin(), component.end(), part);
  };
  const std::uint32_t one = component[lone.first];
  const std::uint32_t other = component[lone.second];
  return one != other && has_cycle(one) && has_cycle(other);
}

TEST(WeakLinks, AreThoseThatPartCyclesInRandomGraphs) {
  std::mt19937 engine(1);
  std::size_t links = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Edges edges;
    for (std::uint64_t p = 1; p < 30; ++p) edges.emplace_back(engine() % 4 == 0 ? engine() % p : p - 1, p);
    for (int extra = 0; extra < 5; ++extra) {
      const std::uint64_t a = engine() % 30;
      const std::uint64_t b = engine() % 30;
      if (a != b) edges.emplace_back(std::min(a, b), std::max(a, b));
    }
    const std::set<std::pair<std::uint64_t, std::uint64_t>> different(edges.begin(), edges.end());
    std::size_t expected = 0;
    for (const auto& edge : different) {
      if (std::count(edges.begin(), edges.end(), edge) == 1 && parts_cycles(different, edge)) ++expected;
    }
    std::size_t found = 0;
    for (const auto& chain : chains_of(log_of(edges))) found += chain[2];
    EXPECT_EQ(found, expected) << trial;
    links += expected;
  }
  EXPECT_GT(links, 50u);
}

template <typename Dimension>
class WeakLinksOf : public ::testing::Test {};
TYPED_TEST_SUITE(WeakLinksOf, Dimensions);

TYPED_TEST(WeakLinksOf, AWorldFullOfFeaturesAreNone) {
  constexpr int Dim = TypeParam::value;
  const auto world = small_world<Dim>();
  EXPECT_TRUE(weak_links(world.log).chains.empty());
  EXPECT_TRUE(weak_links(world.log).features.empty());
}

}  // namespace
}  // namespace mapjoin::testing
