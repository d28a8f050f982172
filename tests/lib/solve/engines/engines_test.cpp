// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <mapjoin/solve/engines/cholmod_solver.hpp>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <mapjoin/solve/sparse_solver.hpp>
#include <tests/support/grid_system.hpp>
#include <tests/support/process.hpp>
#include <tests/support/random.hpp>
#include <tests/support/sparse.hpp>
#include <tuple>

namespace mapjoin {
namespace {

using testing::dense;
using testing::grid_system;
using testing::Random;

/// A random system of blocks, as of poses (of `pose` entries) and features (of `feature` entries): Σ JᵀJ over random pairs.
BlockLower random_system(Eigen::Index pose, Eigen::Index feature, std::size_t blocks, Random& random) {
  std::vector<Eigen::Index> dofs;
  std::vector<Eigen::Index> offsets{0};
  for (std::size_t k = 0; k < blocks; ++k) {
    dofs.push_back(k % 3 == 0 ? feature : pose);
    offsets.push_back(offsets.back() + dofs.back());
  }
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(offsets.back(), offsets.back());
  for (std::size_t k = 1; k < 2 * blocks; ++k) {
    const std::size_t a = k % blocks;
    const auto b = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(blocks) - 1e-9));
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(pose, offsets.back());
    for (const std::size_t block : {a, b}) {
      for (auto& entry : J.middleCols(offsets[block], dofs[block]).reshaped()) entry = random.uniform(-1.0, 1.0);
    }
    A += J.transpose() * J;
  }
  return testing::sparse(A, dofs);
}

/// Zeroes the row and the column of one entry of a matrix, as if nothing measured it.
void free_entry(BlockLower& matrix, Eigen::Index entry) {
  for (const Column k : matrix.columns()) {
    Eigen::Index at = 0;
    for (const Column i : matrix.rows[k]) {
      const Eigen::Index row = entry - matrix.offsets[i];
      if (row >= 0 && row < matrix.dof(i)) matrix.panel(k).row(at + row).setZero();
      at += matrix.dof(i);
    }
    const Eigen::Index column = entry - matrix.offsets[k];
    if (column >= 0 && column < matrix.dof(k)) matrix.panel(k).col(column).setZero();
  }
}

class EnginesTest : public ::testing::TestWithParam<Engine> {
 protected:
  std::unique_ptr<SparseSolver> solver = make_solver(GetParam());
  Random random;
};

TEST_P(EnginesTest, SolveLikeTheDenseSystem) {
  for (const auto& [pose, feature, blocks] : {std::tuple{3, 2, 1u}, {3, 2, 40u}, {6, 3, 40u}, {3, 2, 150u}, {6, 3, 120u}}) {
    const BlockLower matrix = random_system(pose, feature, blocks, random);
    const Eigen::MatrixXd A = dense(matrix);
    Eigen::MatrixXd B(A.rows(), 3);
    for (auto& entry : B.reshaped()) entry = random.uniform(-1.0, 1.0);
    solver->analyse(matrix);
    ASSERT_TRUE(solver->factorise(matrix).empty()) << pose << " " << blocks;
    const Eigen::MatrixXd X = A.llt().solve(B);
    EXPECT_LT((solver->solve_columns(B) - X).norm(), 1e-11 * X.norm()) << pose << " " << blocks;
  }
}

TEST_P(EnginesTest, ShowTheirSupernodes) {
  const BlockLower matrix = grid_system(15, random);
  solver->analyse(matrix);
  ASSERT_TRUE(solver->factorise(matrix).empty());
  const Supernodes factor = solver->supernodes();
  EXPECT_EQ(factor.size(), solver->supernode_count());
  std::int64_t values = 0;
  for (const Supernode& node : factor) values += std::ssize(node.rows) * node.width();
  EXPECT_EQ(solver->bytes(), 8 * values);
  for (const Supernode& node : factor) {
    for (auto column = node.begin; column < node.end; ++column) {
      const Supernode same = solver->supernode_of(column);
      EXPECT_EQ(std::tie(same.begin, same.end, same.rows, same.values), std::tie(node.begin, node.end, node.rows, node.values));
    }
  }
  const Eigen::MatrixXd L = testing::dense_factor(factor, matrix.size());
  EXPECT_LT((L * L.transpose() - dense(matrix)).norm(), 1e-12 * L.norm());
  const InverseSubset subset(factor);
  const std::vector<std::int64_t> last{matrix.size() - 2, matrix.size() - 1};
  const Eigen::MatrixXd inverse = dense(matrix).inverse();
  EXPECT_LT((subset.block(last) - inverse.bottomRightCorner(2, 2)).norm(), 1e-12);
}

TEST_P(EnginesTest, NameTheFirstSingularColumnAndAreFitForUseAgain) {
  for (const auto& [pose, feature] : {std::pair{3, 2}, {6, 3}}) {
    const BlockLower regular = random_system(pose, feature, 90, random);
    BlockLower singular = regular;
    for (const Eigen::Index entry : {singular.size() / 2, singular.size() - 2}) free_entry(singular, entry);
    solver->analyse(regular);
    const auto columns = solver->factorise(singular);
    ASSERT_FALSE(columns.empty());
    EXPECT_EQ(columns.front(), singular.size() / 2);
    EXPECT_TRUE(solver->factorise(regular).empty());
    const Eigen::VectorXd b = Eigen::VectorXd::Ones(regular.size());
    EXPECT_LT((dense(regular) * solver->solve(b) - b).norm(), 1e-9);
  }
}

TEST_P(EnginesTest, FindWhatCancelsButForRounding) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(6, 6);
  A(2, 2) = 0.1 * 0.1 * 1e6;
  A(2, 4) = A(4, 2) = 0.1 * 0.3 * 1e6;
  A(4, 4) = 0.3 * 0.3 * 1e6 * (1.0 + 1e-15);
  const BlockLower matrix = testing::sparse(A);
  solver->analyse(matrix);
  EXPECT_EQ(solver->factorise(matrix), std::vector<std::int64_t>{4});
}

TEST_P(EnginesTest, GiveTheSameSolutionAsTheOther) {
  const BlockLower matrix = grid_system(40, random);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(matrix.size(), -1.0, 2.0);
  const auto solution_of = [&](SparseSolver& by) {
    by.analyse(matrix);
    EXPECT_TRUE(by.factorise(matrix).empty());
    return by.solve(b);
  };
  const auto other = make_solver(GetParam() == Engine::kFronts ? Engine::kCholmod : Engine::kFronts);
  const Eigen::VectorXd x = solution_of(*solver);
  EXPECT_LT((x - solution_of(*other)).norm(), 1e-13 * x.norm());
}

TEST_P(EnginesTest, HasNothingToFactoriseWhereNothingIsFree) {
  NormalEquations equations({}, GetParam());
  EXPECT_EQ(equations.factorise(0.0), std::nullopt);
  EXPECT_EQ(equations.factor_bytes(), 0);
  EXPECT_TRUE(equations.supernodes().empty());
}

std::vector<Engine> every_engine() {
  std::vector<Engine> all;
  for (const auto& [engine, name] : enum_names(Engine())) all.push_back(engine);
  return all;
}

INSTANTIATE_TEST_SUITE_P(Every, EnginesTest, ::testing::ValuesIn(every_engine()),
                         [](const auto& info) { return to_string(info.param); });

TEST(Cholmod, StartsNoThreads) {
  // One thread only: those of TBB would start some time later, and be counted.
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  Random random;
  const BlockLower matrix = grid_system(90, random);
  const auto cholmod = make_solver(Engine::kCholmod);
  const std::ptrdiff_t before = testing::threads_of("self");
  cholmod->analyse(matrix);
  ASSERT_TRUE(cholmod->factorise(matrix).empty());
  cholmod->solve(Eigen::VectorXd::Ones(matrix.size()));
  EXPECT_LE(testing::threads_of("self"), before);
}

TEST(Cholmod, WorksWithoutItsSupernodalPart) {
  Random random;
  const BlockLower matrix = grid_system(15, random);
  CholmodSolver simplicial(false);
  simplicial.analyse(matrix);
  ASSERT_TRUE(simplicial.factorise(matrix).empty());
  EXPECT_EQ(simplicial.supernode_count(), static_cast<std::size_t>(matrix.size()));
  const Eigen::MatrixXd A = dense(matrix);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(matrix.size(), -1.0, 2.0);
  EXPECT_LT((simplicial.solve(b) - A.llt().solve(b)).norm(), 1e-12 * b.norm());
  const InverseSubset subset(simplicial.supernodes());
  EXPECT_LT((subset.block(std::vector<std::int64_t>{0}) - A.inverse().topLeftCorner(1, 1)).norm(), 1e-12);
  BlockLower singular = matrix;
  free_entry(singular, 100);
  EXPECT_EQ(simplicial.factorise(singular), std::vector<std::int64_t>{100});
}

TEST(Fronts, SpanTheNullSpaceOfASingularMatrix) {
  // Observations of differences alone: each of three connected components is free to move as a whole.
  Random random;
  const Eigen::Index blocks = 120;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6 * blocks, 3 * blocks);
  for (Eigen::Index k = 0; k < 2 * blocks; ++k) {
    const Eigen::Index a = k % blocks;
    const Eigen::Index b = k < blocks ? a + 1 : a / 40 * 40 + static_cast<Eigen::Index>(random.uniform(0.0, 39.99));
    if (a / 40 != b / 40 || a == b) continue;
    Eigen::Matrix3d M;
    for (auto& entry : M.reshaped()) entry = random.uniform(-1.0, 1.0);
    J.block<3, 3>(3 * k, 3 * a) = -M;
    J.block<3, 3>(3 * k, 3 * b) = M;
  }
  const BlockLower matrix = testing::sparse(J.transpose() * J, std::vector<Eigen::Index>(blocks, 3));
  SparseCholesky fronts;
  fronts.analyse(matrix);
  const auto singular = fronts.factorise(matrix);
  EXPECT_EQ(fronts.null_space(4).cols(), 4);
  const Eigen::MatrixXd N = fronts.null_space(singular.size());
  ASSERT_EQ(N.cols(), 9);
  EXPECT_EQ(N.fullPivLu().rank(), 9);
  EXPECT_LT((J * N).norm(), 1e-6 * N.norm());
}

TEST(Fronts, LeaveSingularColumnsOut) {
  // A wide front of several tiles, some of which have singular columns.
  Random random;
  Eigen::MatrixXd J(700, 600);
  for (auto& entry : J.reshaped()) entry = random.uniform(-1.0, 1.0);
  J.col(100) = J.col(40) + J.col(99);
  J.col(101).setZero();
  J.col(400) = J.col(101) - 2.0 * J.col(300);
  J.col(590) = J.col(589);
  const Eigen::MatrixXd A = J.transpose() * J;
  const BlockLower matrix = testing::sparse(A, std::vector<Eigen::Index>(200, 3));
  SparseCholesky fronts;
  fronts.analyse(matrix);
  const auto singular = fronts.factorise(matrix);
  EXPECT_EQ(singular, (std::vector<std::int64_t>{100, 101, 400, 590}));
  // A consistent system is solved nevertheless; variables that nothing determines stay at zero.
  const Eigen::VectorXd b = A * Eigen::VectorXd::LinSpaced(600, -1.0, 1.0);
  const Eigen::VectorXd x = fronts.solve(b);
  EXPECT_LT((A * x - b).norm(), 1e-7 * b.norm());
  for (const auto column : singular) EXPECT_LT(std::abs(x[column]), 1e-6);
}

}  // namespace
}  // namespace mapjoin
