// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/solve/engines/supernodal_tree.hpp>
#include <set>
#include <tests/support/grid_system.hpp>
#include <tests/support/random.hpp>
#include <tests/support/sparse.hpp>

namespace mapjoin {
namespace {

using testing::grid_system;
using testing::Random;

/// The block rows below the diagonal in each column of L, by eliminating one column after the other.
Table<Column, std::set<Column>> rows_of_factor(const BlockLower& A) {
  Table<Column, std::set<Column>> below(A.rows.size());
  for (const Column k : A.columns()) below[k].insert(A.rows[k].begin() + 1, A.rows[k].end());
  for (auto& column : below) {
    if (column.empty()) continue;
    auto& parent = below[*column.begin()];
    parent.insert(std::next(column.begin()), column.end());
  }
  return below;
}

class SupernodalTreeTest : public ::testing::TestWithParam<int> {
 protected:
  BlockLower A = grid_system(GetParam(), random_);
  SupernodalTree tree = supernodal_tree(A);

 private:
  Random random_;
};

TEST_P(SupernodalTreeTest, HoldsEveryEntryThatEliminationFills) {
  const auto below = rows_of_factor(A);
  Column next = 0;
  for (const FactorNode& node : tree.nodes) {
    ASSERT_EQ(node.columns.first, next);
    const auto rows = tree.rows_of(node);
    next = node.columns.last;
    for (const Column k : node.columns) {
      for (const Column row : below[k]) {
        const bool is_own = row < node.columns.last;
        EXPECT_TRUE(is_own || std::binary_search(rows.begin(), rows.end(), row));
      }
    }
  }
  EXPECT_EQ(next, A.columns().last);
}

TEST_P(SupernodalTreeTest, TakesFewZerosAlong) {
  std::int64_t entries = 0;
  const auto below = rows_of_factor(A);
  for (const Column k : A.columns()) {
    Eigen::Index rows = A.dof(k);
    for (const Column row : below[k]) rows += A.dof(row);
    entries += rows * A.dof(k);
  }
  // Panels are rectangles, which hold zeros above their diagonal, too.
  EXPECT_LT(tree.value_count, 2 * entries);
}

TEST_P(SupernodalTreeTest, NamesTheSameRowsInTheParentsFront) {
  for (const FactorNode& node : tree.nodes) {
    if (node.parent == tree.nodes.size()) continue;
    const FactorNode& parent = tree.nodes[node.parent];
    // The scalar rows of a front, with or without those of its own columns.
    const auto rows_of = [&](const FactorNode& of, bool with_own) {
      std::vector<Eigen::Index> rows;
      const auto append = [&](Column block) {
        for (auto row = A.offsets[block]; row < A.offsets[block + 1]; ++row) rows.push_back(row);
      };
      if (with_own) std::for_each(of.columns.begin(), of.columns.end(), append);
      for (const Column row : tree.rows_of(of)) append(row);
      return rows;
    };
    const auto from = rows_of(node, false);
    const auto to = rows_of(parent, true);
    Eigen::Index taken = 0;
    for (const RowRun& run : tree.runs_of(node)) {
      for (std::int32_t i = 0; i < run.length; ++i) {
        EXPECT_EQ(from[static_cast<std::size_t>(run.from + i)], to[static_cast<std::size_t>(run.to + i)]);
      }
      taken += run.length;
    }
    EXPECT_EQ(taken, node.below());
  }
}

void collect(const FactorTask& task, std::vector<std::size_t>& nodes, std::size_t& tasks) {
  ++tasks;
  for (const FactorTask& before : task.before) collect(before, nodes, tasks);
  nodes.insert(nodes.end(), task.nodes.begin(), task.nodes.end());
}

TEST_P(SupernodalTreeTest, GivesEverySupernodeToOneTaskAfterItsChildren) {
  std::vector<std::size_t> order;
  std::size_t tasks = 0;
  collect(tree.tasks, order, tasks);
  std::vector<std::size_t> place(tree.nodes.size(), tree.nodes.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    ASSERT_EQ(place[order[k]], tree.nodes.size());
    place[order[k]] = k;
  }
  ASSERT_EQ(order.size(), tree.nodes.size());
  for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
    if (tree.nodes[s].parent == tree.nodes.size()) continue;
    EXPECT_LT(place[s], place[tree.nodes[s].parent]);
  }
  EXPECT_EQ(tasks > 4, GetParam() >= 60);
  EXPECT_EQ(tasks == 1, GetParam() <= 12);
}

INSTANTIATE_TEST_SUITE_P(Sides, SupernodalTreeTest, ::testing::Values(1, 2, 3, 12, 60),
                         [](const auto& info) { return std::to_string(info.param); });

TEST(SupernodalTree, TakesAnEliminationThatIsNotPostordered) {
  // Two chains with alternating columns: 0-2-4-6 and 1-3-5-7.
  Eigen::MatrixXd dense = 4.0 * Eigen::MatrixXd::Identity(8, 8);
  for (Eigen::Index i = 0; i < 6; ++i) dense(i, i + 2) = dense(i + 2, i) = 1.0;
  const BlockLower A = testing::sparse(dense);
  const SupernodalTree tree = supernodal_tree(A);
  EXPECT_EQ(tree.nodes.back().parent, tree.nodes.size());
  std::size_t columns = 0;
  for (const FactorNode& node : tree.nodes) columns += node.columns.size();
  EXPECT_EQ(columns, 8u);
}

}  // namespace
}  // namespace mapjoin
