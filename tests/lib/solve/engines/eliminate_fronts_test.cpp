// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <mapjoin/model/lists.hpp>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <tests/support/coupled_by_fronts.hpp>
#include <tests/support/grid_system.hpp>
#include <tests/support/random.hpp>
#include <tests/support/sparse.hpp>

namespace mapjoin {
namespace {

using testing::dense;
using testing::grid_system;
using testing::Random;

/// The product L Lᵀ of fronts that were eliminated from a matrix with the block sizes of `matrix`.
Eigen::MatrixXd product(const EliminatedFronts& fronts, const BlockLower& matrix) {
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(matrix.size(), matrix.size());
  for (std::size_t n = 0; n < fronts.tree.nodes.size(); ++n) {
    const FactorNode& node = fronts.tree.nodes[n];
    if (node.width == 0) continue;
    std::vector<Column> blocks(node.columns.begin(), node.columns.end());
    append(blocks, fronts.tree.rows_of(node));
    std::vector<Eigen::Index> rows;
    for (const Column block : blocks) {
      for (auto row = matrix.offsets[block]; row < matrix.offsets[block + 1]; ++row) rows.push_back(row);
    }
    L(rows, Eigen::seqN(rows.front(), node.width)) = fronts.panels[n].triangularView<Eigen::Lower>();
  }
  return L * L.transpose();
}

TEST(EliminateFronts, PanelsMakeUpTheFactor) {
  Random random;
  const BlockLower matrix = grid_system(12, random);
  const EliminatedFronts fronts = eliminate_fronts(matrix, {});
  EXPECT_TRUE(fronts.singular.empty());
  const Eigen::MatrixXd A = dense(matrix);
  EXPECT_LT((product(fronts, matrix) - A).norm(), 1e-12 * A.norm());
}

TEST(EliminateFronts, KeepsAllButWhatWasGiven) {
  Random random;
  const testing::CoupledByFronts given(random);
  const EliminatedFronts fronts = eliminate_fronts(given.pattern, given.fronts);
  EXPECT_LT((product(fronts, given.pattern) - given.A).norm(), 1e-12 * given.A.norm());
  for (std::size_t n = 0; n < fronts.tree.nodes.size(); ++n) {
    const FactorNode& node = fronts.tree.nodes[n];
    EXPECT_EQ(fronts.panels[n].size(), node.width * node.height);
    EXPECT_EQ(fronts.updates[n].rows(), node.width == 0 ? 0 : node.below());
  }
}

TEST(EliminateFronts, AColumnIsOfTheSupernodeBehindWhatWasGiven) {
  Random random;
  const testing::CoupledByFronts given(random);
  SparseCholesky cholesky;
  cholesky.analyse(given.pattern, given.fronts);
  ASSERT_TRUE(cholesky.factorise(given.pattern, given.fronts).empty());
  const Eigen::MatrixXd L = testing::dense_factor(cholesky.supernodes(), given.A.rows());
  EXPECT_LT((L * L.transpose() - given.A).norm(), 1e-12 * given.A.norm());
}

TEST(EliminateFronts, PanelsAreThoseOfSparseCholeskyToTheLastBitForAnyNumberOfThreads) {
  Random random;
  const BlockLower matrix = grid_system(90, random);
  SparseCholesky cholesky;
  cholesky.analyse(matrix);
  ASSERT_TRUE(cholesky.factorise(matrix).empty());
  const Supernodes expected = cholesky.supernodes();
  for (const std::size_t threads : {1u, 4u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const EliminatedFronts fronts = eliminate_fronts(matrix, {});
    ASSERT_EQ(fronts.panels.size(), expected.size());
    for (std::size_t n = 0; n < expected.size(); ++n) {
      const auto& panel = fronts.panels[n];
      const Eigen::Map<const Eigen::MatrixXd> L(expected[n].values, panel.rows(), panel.cols());
      const Eigen::MatrixXd difference = (panel - L).triangularView<Eigen::Lower>();
      EXPECT_TRUE(difference.isZero(0.0)) << n << " by " << threads;
    }
  }
}

TEST(EliminateFronts, SaysWhatIsSingular) {
  Random random;
  BlockLower matrix = grid_system(12, random);
  matrix.panel(Column(70))(1, 1) = -1.0;
  EXPECT_EQ(eliminate_fronts(matrix, {}).singular, std::vector<std::int64_t>{matrix.offsets[70] + 1});
}

}  // namespace
}  // namespace mapjoin
