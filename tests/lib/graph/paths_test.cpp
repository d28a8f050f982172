// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/graph/graph.hpp>
#include <random>

namespace mapjoin::testing {
namespace {

using ::testing::ElementsAre;

TEST(Paths, RunAsTheirEdgesPoint) {
  EXPECT_THAT(cover_by_paths(4, {{3, 1}, {1, 0}, {0, 2}}).order, ElementsAre(3, 1, 0, 2));
  EXPECT_THAT(cover_by_paths(4, {{2, 0}, {0, 1}, {1, 3}}).order, ElementsAre(2, 0, 1, 3));
}

TEST(Paths, WhoseEdgesDisagreeRunFromTheEndThatComesFirst) {
  EXPECT_THAT(cover_by_paths(3, {{2, 1}, {0, 1}}).order, ElementsAre(2, 1, 0));
  EXPECT_THAT(cover_by_paths(3, {{1, 2}, {1, 0}}).order, ElementsAre(2, 1, 0));
}

TEST(Paths, FollowEachOtherAsTheEdgesMentionThem) {
  const PathCover cover = cover_by_paths(6, {{5, 4}, {1, 3}, {3, 0}});
  EXPECT_THAT(cover.order, ElementsAre(5, 4, 1, 3, 0, 2));
  EXPECT_EQ(cover.edges, 3u);
}

TEST(Paths, AreMadeOfTheFirstEdges) {
  // The edges of a drive: closures 2 to 0 and 4 to 1 come after the odometry that leads to them.
  const PathCover cover = cover_by_paths(5, {{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 1}});
  EXPECT_THAT(cover.order, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(cover.edges, 4u);
}

TEST(Paths, AreMadeOfEdgesWithFewOthersWhereThatLeavesFewer) {
  // Edges taken in their own order, from 1 to 3 on, make the path 2, 3, 1, 4, 5, and leave 0 out.
  const std::vector<Edge> edges = {{1, 3}, {1, 4}, {0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}};
  const PathCover cover = cover_by_paths(6, edges);
  EXPECT_EQ(cover.edges, 5u);
  EXPECT_THAT(cover.order, ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(Paths, TakeNoEdgeFromAVertexToItself) {
  const PathCover cover = cover_by_paths(3, {{1, 1}, {1, 0}, {0, 0}, {0, 2}});
  EXPECT_THAT(cover.order, ElementsAre(1, 0, 2));
  EXPECT_EQ(cover.edges, 2u);
}

TEST(Paths, HoldEveryVertexOnceInRandomGraphs) {
  std::mt19937 engine(1);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<Edge> edges;
    for (int e = 0; e < 40; ++e) {
      const auto a = static_cast<Vertex>(engine() % 30);
      const auto b = static_cast<Vertex>(engine() % 30);
      if (a != b) edges.emplace_back(a, b);
    }
    const PathCover cover = cover_by_paths(30, edges);
    std::vector<Vertex> sorted = cover.order;
    std::ranges::sort(sorted);
    for (Vertex v = 0; v < 30; ++v) ASSERT_EQ(sorted.at(v), v);
    std::size_t tied = 0;
    for (std::size_t k = 1; k < 30; ++k) {
      const Edge step{cover.order[k - 1], cover.order[k]};
      tied += std::ranges::count_if(edges, [&](const Edge& e) { return e == step || Edge{e.second, e.first} == step; }) > 0;
    }
    EXPECT_GE(tied, cover.edges);
  }
}

TEST(Paths, AreTheSameOfEdgesThatStandAlongThem) {
  std::mt19937 engine(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto vertices = static_cast<Vertex>(4 + engine() % 20);
    std::vector<Edge> edges;
    for (std::size_t e = 0; e < vertices + engine() % 20; ++e) {
      const auto a = static_cast<Vertex>(engine() % vertices);
      const auto b = static_cast<Vertex>(engine() % vertices);
      if (a != b) edges.emplace_back(a, b);
    }
    const PathCover cover = cover_by_paths(vertices, edges);
    std::vector<std::size_t> place(vertices);
    for (std::size_t k = 0; k < vertices; ++k) place[cover.order[k]] = k;
    const auto rank = [&](const Edge& edge) {
      const auto [first, second] = std::minmax(place[edge.first], place[edge.second]);
      return second == first + 1 ? second : vertices;
    };
    std::ranges::stable_sort(edges, {}, rank);
    ASSERT_EQ(cover_by_paths(vertices, edges).order, cover.order) << "trial " << trial;
  }
}

}  // namespace
}  // namespace mapjoin::testing
