// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/solve/ordering.hpp>
#include <numeric>
#include <set>
#include <tests/support/grid_system.hpp>
#include <thread>

namespace mapjoin {
namespace {

using testing::grid;

/// Blocks of the Cholesky factor below the diagonal, by eliminating one variable after the other.
std::size_t fill(const BlockGraph& graph, const std::vector<Index>& order) {
  std::vector<std::set<Index>> adjacent(static_cast<std::size_t>(graph.size()));
  for (Index v = 0; v < graph.size(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    adjacent[i].insert(graph.neighbours.begin() + graph.begin[i], graph.neighbours.begin() + graph.begin[i + 1]);
  }
  std::size_t blocks = 0;
  for (const Index v : order) {
    const std::set<Index> clique = std::move(adjacent[static_cast<std::size_t>(v)]);
    blocks += clique.size();
    for (const Index a : clique) {
      auto& of_a = adjacent[static_cast<std::size_t>(a)];
      of_a.insert(clique.begin(), clique.end());
      of_a.erase(a);
      of_a.erase(v);
    }
  }
  return blocks;
}

std::vector<Index> natural(Index count) {
  std::vector<Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

TEST(Ordering, IsAPermutationThatFillsLessThanTheNaturalOrder) {
  for (const Index side : {8, 30}) {
    const BlockGraph graph = grid(side);
    std::vector<Index> order = elimination_order(graph);
    EXPECT_LT(static_cast<double>(fill(graph, order)), 0.8 * static_cast<double>(fill(graph, natural(graph.size())))) << side;
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, natural(graph.size()));
  }
}

TEST(Ordering, TakesVariablesWithoutNeighbours) {
  EXPECT_TRUE(elimination_order({{0}, {}}).empty());
  EXPECT_EQ(elimination_order({{0, 0, 0}, {}}), natural(2));
  BlockGraph graph = grid(20);
  for (int k = 0; k < 5; ++k) graph.begin.push_back(graph.begin.back());
  std::vector<Index> order = elimination_order(graph);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, natural(405));
}

TEST(Ordering, EliminatesTheLastVariablesAfterAllThatTheyAreCoupledTo) {
  for (const Index side : {6, 20}) {
    const BlockGraph graph = grid(side);
    const Index first_late = graph.size() - 9;
    const std::vector<Index> order = elimination_order(graph, {.given = {}, .last_count = 9});
    const std::vector<Index> place = inverse_order(order);
    for (Index v = first_late; v < graph.size(); ++v) {
      for (auto n = graph.begin[static_cast<std::size_t>(v)]; n < graph.begin[static_cast<std::size_t>(v) + 1]; ++n) {
        const Index neighbour = graph.neighbours[static_cast<std::size_t>(n)];
        if (neighbour >= first_late) continue;
        EXPECT_LT(place[static_cast<std::size_t>(neighbour)], place[static_cast<std::size_t>(v)]);
      }
    }
    EXPECT_LT(fill(graph, order), fill(graph, natural(graph.size())));
  }
}

TEST(Ordering, IsTheSameFromSeveralThreadsAtOnce) {
  const BlockGraph first = grid(25);
  const BlockGraph second = grid(18);
  const std::vector<Index> of_first = elimination_order(first);
  const std::vector<Index> of_second = elimination_order(second);
  std::vector<std::vector<Index>> orders(16);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < orders.size(); ++k) {
    threads.emplace_back([&, k] { orders[k] = elimination_order(k % 2 == 0 ? first : second); });
  }
  for (auto& thread : threads) thread.join();
  for (std::size_t k = 0; k < orders.size(); ++k) EXPECT_EQ(orders[k], k % 2 == 0 ? of_first : of_second);
}

}  // namespace
}  // namespace mapjoin
