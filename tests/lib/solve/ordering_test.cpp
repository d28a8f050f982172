// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <mapjoin/solve/ordering.hpp>
#include <set>
#include <tests/support/grid_system.hpp>
#include <tests/support/sparse.hpp>
#include <thread>

namespace mapjoin {
namespace {

using testing::grid;

/// The number of blocks of the Cholesky factor below its diagonal, by eliminating one variable after the other.
std::size_t fill(const BlockGraph& graph, const Table<Column, Variable>& order) {
  Table<Variable, std::set<Variable>> adjacent(graph.size());
  for (const Variable v : indices(adjacent)) adjacent[v].insert(graph[v].begin(), graph[v].end());
  std::size_t blocks = 0;
  for (const Variable v : order) {
    const std::set<Variable> clique = std::move(adjacent[v]);
    blocks += clique.size();
    for (const Variable a : clique) {
      auto& of_a = adjacent[a];
      of_a.insert(clique.begin(), clique.end());
      of_a.erase(a);
      of_a.erase(v);
    }
  }
  return blocks;
}

Table<Column, Variable> natural(std::size_t count) {
  const IndexRange<Variable> all{0, Variable(count)};
  return {all.begin(), all.end()};
}

TEST(Partition, CutsAGridIntoHalvesAcross) {
  const int side = 30;
  const BlockGraph graph = grid(side);
  const auto part = partition(graph, Table<Variable, std::int32_t>(graph.size(), 1), 2);
  const auto first = std::count(part.begin(), part.end(), 0);
  EXPECT_NEAR(static_cast<double>(first), 450.0, 25.0);
  int cut = 0;
  for (const Variable v : indices(part)) {
    for (const Variable other : graph[v]) cut += part[v] < part[other] ? 1 : 0;
  }
  EXPECT_LE(cut, side + 5);  // a straight cut has as many edges as the grid has rows
  EXPECT_EQ(partition(graph, Table<Variable, std::int32_t>(graph.size(), 1), 2), part);
}

TEST(Ordering, EndsWithTheBorderInItsOrder) {
  for (const int side : {2, 9, 30}) {
    const BlockGraph graph = grid(side);
    const std::vector<Variable> border = {3, 0, 1};
    const auto order = elimination_order(graph, {.border = border});
    ASSERT_EQ(order.size(), graph.size());
    EXPECT_EQ(std::set<Variable>(order.begin(), order.end()).size(), graph.size());
    EXPECT_TRUE(std::equal(border.begin(), border.end(), order.end() - 3)) << side;
  }
}

TEST(Ordering, IsAPermutationThatFillsLessThanTheNaturalOrder) {
  for (const int side : {8, 30}) {
    const BlockGraph graph = grid(side);
    Table<Column, Variable> order = elimination_order(graph);
    EXPECT_LT(static_cast<double>(fill(graph, order)), 0.8 * static_cast<double>(fill(graph, natural(graph.size())))) << side;
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, natural(graph.size()));
  }
}

TEST(Ordering, DissectsByWeight) {
  const std::int32_t length = 400;
  BlockGraph path;
  for (std::int32_t k = 0; k < length; ++k) {
    std::vector<Variable> neighbours;
    if (k > 0) neighbours.emplace_back(k - 1);
    if (k + 1 < length) neighbours.emplace_back(k + 1);
    path.push_back(neighbours);
  }
  const auto separator = [&](const Ordering& ordering) { return elimination_order(path, ordering).back().value; };
  EXPECT_NEAR(separator({}), 200, 60);
  Table<Variable, int> weights(length, 1);
  std::fill(weights.begin(), weights.begin() + 100, 100);
  EXPECT_NEAR(separator({.weights = weights}), 50, 25);
}

TEST(Ordering, TakesVariablesWithoutNeighbours) {
  const std::vector<Variable> none;
  EXPECT_TRUE(elimination_order({}).empty());
  BlockGraph two;
  for (int k = 0; k < 2; ++k) two.push_back(none);
  EXPECT_EQ(elimination_order(two), natural(2));
  BlockGraph graph = grid(20);
  for (int k = 0; k < 5; ++k) graph.push_back(none);
  Table<Column, Variable> order = elimination_order(graph);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, natural(405));
}

TEST(Ordering, EliminatesAVariableAfterAllOfLowerRankThatItIsCoupledTo) {
  for (const int side : {6, 20, 30}) {
    const BlockGraph graph = grid(side);
    Table<Variable, int> ranks(graph.size(), 0);
    std::fill(ranks.end() - 9, ranks.end(), 1);
    ranks[3] = 2;
    const Table<Column, Variable> order = elimination_order(graph, {.ranks = ranks});
    const Table<Variable, Column> column = inverse_order(order);
    for (const Variable v : order) {
      for (const Variable neighbour : graph[v]) {
        EXPECT_TRUE(ranks[neighbour] >= ranks[v] || column[neighbour] < column[v]);
      }
    }
    EXPECT_LT(fill(graph, order), fill(graph, natural(graph.size())));
  }
}

TEST(Ordering, TakesRanksBeyondTheNumberOfVariables) {
  BlockGraph pair;
  pair.push_back(std::array<Variable, 1>{1});
  pair.push_back(std::array<Variable, 1>{0});
  EXPECT_EQ(elimination_order(pair, {.ranks = {7, 2}}), (Table<Column, Variable>{1, 0}));
}

TEST(Ordering, IsTheSameFromSeveralThreadsAtOnce) {
  const BlockGraph first = grid(25);
  const BlockGraph second = grid(18);
  const auto of_first = elimination_order(first);
  const auto of_second = elimination_order(second);
  std::vector<Table<Column, Variable>> orders(16);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < orders.size(); ++k) {
    threads.emplace_back([&, k] { orders[k] = elimination_order(k % 2 == 0 ? first : second); });
  }
  for (auto& thread : threads) thread.join();
  for (std::size_t k = 0; k < orders.size(); ++k) EXPECT_EQ(orders[k], k % 2 == 0 ? of_first : of_second);
}

TEST(Ordering, HasEverySubtreeInOneRun) {
  testing::Random random;
  const EliminationTree tree = elimination_tree(testing::grid_system(12, random));
  Table<Column, int> sizes(tree.parent.size() + 1, 1);  // sizes of the subtrees
  for (const Column k : indices(tree.parent)) sizes[tree.parent[k]] += sizes[k];
  for (const Column root : indices(tree.parent)) {
    for (const Column below : IndexRange<Column>{root - sizes[root] + 1, root}) EXPECT_LE(tree.parent[below], root);
  }
}

/// The elimination tree by eliminating one column after the other.
EliminationTree eliminated(const BlockLower& A) {
  Table<Column, std::set<Column>> columns(A.rows.size());
  for (const Column k : A.columns()) columns[k].insert(A.rows[k].begin(), A.rows[k].end());
  EliminationTree tree;
  for (auto& column : columns) {
    tree.counts.push_back(static_cast<int>(column.size()));
    column.erase(column.begin());
    tree.parent.push_back(column.empty() ? A.columns().last : *column.begin());
    if (!column.empty()) columns[*column.begin()].insert(column.begin(), column.end());
  }
  return tree;
}

TEST(EliminationTree, HasTheParentsAndCountsOfAnElimination) {
  testing::Random random;
  for (const int side : {1, 2, 9, 30}) {
    const BlockLower A = testing::grid_system(side, random);
    const EliminationTree expected = eliminated(A);
    const EliminationTree tree = elimination_tree(A);
    EXPECT_EQ(tree.parent, expected.parent);
    EXPECT_EQ(tree.counts, expected.counts);
  }
  EXPECT_TRUE(elimination_tree(BlockLower()).parent.empty());
}

TEST(EliminationTree, TakesAnEliminationThatIsNotPostordered) {
  Eigen::MatrixXd dense = 4.0 * Eigen::MatrixXd::Identity(8, 8);
  for (Eigen::Index i = 0; i < 6; ++i) dense(i, i + 2) = dense(i + 2, i) = 1.0;
  const EliminationTree tree = elimination_tree(testing::sparse(dense));
  EXPECT_EQ(tree.parent, (Table<Column, Column>{2, 3, 4, 5, 6, 7, 8, 8}));
  EXPECT_EQ(tree.counts, (Table<Column, int>{2, 2, 2, 2, 2, 2, 1, 1}));
}

}  // namespace
}  // namespace mapjoin
