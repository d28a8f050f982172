// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/solve/elimination_tree.hpp>
#include <set>
#include <tests/support/grid_system.hpp>
#include <tests/support/sparse.hpp>

namespace mapjoin {
namespace {

/// By eliminating one column after the other.
EliminationTree eliminated(const BlockLower& A) {
  std::vector<std::set<Index>> columns(A.blocks());
  for (std::size_t k = 0; k < A.blocks(); ++k) columns[k].insert(A.rows_of(k).begin(), A.rows_of(k).end());
  EliminationTree tree;
  for (auto& column : columns) {
    tree.counts.push_back(static_cast<Index>(column.size()));
    column.erase(column.begin());
    tree.parent.push_back(column.empty() ? static_cast<Index>(A.blocks()) : *column.begin());
    if (!column.empty()) columns[static_cast<std::size_t>(*column.begin())].insert(column.begin(), column.end());
  }
  return tree;
}

TEST(EliminationTree, HasTheParentsAndCountsOfAnElimination) {
  testing::Random random;
  for (const Index side : {1, 2, 9, 30}) {
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
  EXPECT_EQ(tree.parent, (std::vector<Index>{2, 3, 4, 5, 6, 7, 8, 8}));
  EXPECT_EQ(tree.counts, (std::vector<Index>{2, 2, 2, 2, 2, 2, 1, 1}));
}

TEST(Postordered, HasEverySubtreeInOneRun) {
  testing::Random random;
  const EliminationTree tree = elimination_tree(testing::grid_system(12, random));  // in an order that is postordered
  std::vector<Index> sizes(tree.parent.size() + 1, 1);                              // of the subtrees
  for (std::size_t k = 0; k < tree.parent.size(); ++k) sizes[static_cast<std::size_t>(tree.parent[k])] += sizes[k];
  for (std::size_t k = 0; k < tree.parent.size(); ++k) {
    const auto root = static_cast<Index>(k);
    for (Index below = root - sizes[k] + 1; below < root; ++below) {
      EXPECT_LE(tree.parent[static_cast<std::size_t>(below)], root);
    }
  }
}

}  // namespace
}  // namespace mapjoin
