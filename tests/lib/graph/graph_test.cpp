// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/graph/graph.hpp>
#include <random>
#include <ranges>

namespace mapjoin::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<Vertex> vertices_of(const std::vector<Reached>& reached) {
  std::vector<Vertex> vertices;
  for (const Reached& r : reached) vertices.push_back(r.vertex);
  return vertices;
}

std::vector<std::optional<std::uint32_t>> edges_of(const std::vector<Reached>& reached) {
  std::vector<std::optional<std::uint32_t>> edges;
  for (const Reached& r : reached) edges.push_back(r.edge);
  return edges;
}

TEST(Graph, ComponentsAreNumberedByTheirFirstVertices) {
  EXPECT_THAT(components_of(make_graph(6, {{5, 1}, {4, 0}, {2, 5}})), ElementsAre(0, 1, 1, 2, 0, 1));
  EXPECT_THAT(components_of(make_graph(0, {})), IsEmpty());
}

TEST(Graph, ALoopAndARepeatedEdgeTieNothingNew) {
  EXPECT_THAT(components_of(make_graph(3, {{1, 1}, {0, 2}, {2, 0}})), ElementsAre(0, 1, 0));
}

TEST(Bridges, AreTheEdgesOnNoCycle) {
  // Two triangles with two edges between them, an edge to the side, and two vertices of their own.
  const std::vector<Edge> edges = {{7, 8}, {2, 3}, {1, 0}, {1, 2}, {2, 0}, {4, 3}, {4, 5}, {6, 5}, {6, 4}, {9, 1}};
  EXPECT_THAT(bridges_of(10, edges), ElementsAre(true, true, false, false, false, true, false, false, false, true));
  EXPECT_THAT(bridges_of(0, {}), IsEmpty());
}

TEST(Bridges, AreNeitherLoopsNorRepeatedEdges) {
  EXPECT_THAT(bridges_of(4, {{0, 1}, {1, 2}, {2, 1}, {2, 2}, {2, 3}}), ElementsAre(true, false, false, false, true));
}

TEST(Bridges, AreThoseWithoutWhichRandomGraphsFallApart) {
  std::mt19937 engine(3);
  for (int trial = 0; trial < 50; ++trial) {
    constexpr Vertex kVertices = 12;
    std::vector<Edge> edges;
    for (int e = 0; e < 12; ++e) edges.emplace_back(engine() % kVertices, engine() % kVertices);
    const std::vector<bool> are_bridges = bridges_of(kVertices, edges);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      std::vector<Edge> others = edges;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(e));
      const std::vector<std::uint32_t> component = components_of(make_graph(kVertices, others));
      EXPECT_EQ(are_bridges[e], component[edges[e].first] != component[edges[e].second]);
    }
  }
}

TEST(SpanningForest, TakesTheEdgesOfLowestNumber) {
  // A square with a diagonal, of which the last edge of the square and the diagonal are left out.
  const auto reached = spanning_forest(4, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}}, {0});
  EXPECT_THAT(vertices_of(reached), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(edges_of(reached), ElementsAre(std::nullopt, 0, 1, 2));
}

TEST(SpanningForest, IsWalkedBreadthFirst) {
  const auto reached = spanning_forest(6, {{3, 0}, {0, 1}, {1, 2}, {3, 4}, {4, 5}}, {0});
  EXPECT_THAT(vertices_of(reached), ElementsAre(0, 3, 1, 4, 2, 5));
  EXPECT_THAT(edges_of(reached), ElementsAre(std::nullopt, 0, 1, 3, 2, 4));
}

TEST(SpanningForest, HasARootWhereNothingLedBefore) {
  const auto reached = spanning_forest(5, {{4, 3}, {1, 0}}, {1, 0, 2, 3, 4});
  EXPECT_THAT(vertices_of(reached), ElementsAre(1, 0, 2, 3, 4));
  EXPECT_THAT(edges_of(reached), ElementsAre(std::nullopt, 1, std::nullopt, std::nullopt, 0));
}

TEST(LargestClique, HasTheMostVerticesThatAreAllAdjacent) {
  EXPECT_THAT(largest_clique({{0, 1}, {1, 2}, {0, 2}, {2, 3}, {3, 4}, {4, 5}, {2, 4}, {2, 5}, {3, 5}}),
              ElementsAre(2, 3, 4, 5));
  EXPECT_THAT(largest_clique({{7, 3}}), ElementsAre(3, 7));
  EXPECT_THAT(largest_clique({}), IsEmpty());
}

}  // namespace
}  // namespace mapjoin::testing
