// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Cholesky>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <system_error>
#include <tests/support/coupled_by_fronts.hpp>
#include <tests/support/grid_system.hpp>
#include <tests/support/process.hpp>
#include <tests/support/random.hpp>
#include <tests/support/sparse.hpp>
#include <tests/support/temporary_folder.hpp>
#include <thread>

namespace mapjoin {
namespace {

using testing::dense;
using testing::grid_system;
using testing::Random;
using testing::sparse;

/// A sparse positive definite matrix: three observations from each column of itself, the next column and one far away.
Eigen::MatrixXd random_matrix(Eigen::Index n, Random& random) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index k = 0; k < 3 * n; ++k) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    const Eigen::Index i = k % n;
    row[i] = 1.0;
    row[(i + 1) % n] = random.uniform(-1.0, 1.0);
    row[(7 * i + k / n) % n] += random.uniform(-1.0, 1.0);
    A += row * row.transpose();
  }
  return A;
}

TEST(SparseCholesky, SolvesLikeTheDenseSystem) {
  Random random;
  for (const Eigen::Index n : {1, 2, 9, 60, 400}) {
    const Eigen::MatrixXd A = random_matrix(n, random);
    const BlockLower matrix = sparse(A);
    SparseCholesky cholesky;
    cholesky.analyse(matrix);
    ASSERT_TRUE(cholesky.factorise(matrix).empty()) << n;
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(n, -1.0, 2.0);
    EXPECT_LT((A * cholesky.solve(b) - b).norm(), 1e-10 * b.norm()) << n;
  }
}

TEST(SparseCholesky, LeavesTheSchurComplementOfABorder) {
  Random random;
  for (const int side : {2, 7, 25}) {
    for (const std::size_t border : {std::size_t{1}, std::size_t{3}, static_cast<std::size_t>(side * side)}) {
      const BlockLower matrix = grid_system(side, random);
      const Eigen::MatrixXd A = dense(matrix);
      SparseCholesky cholesky(border);
      cholesky.analyse(matrix);
      ASSERT_TRUE(cholesky.factorise(matrix).empty());
      const Eigen::Index inside = matrix.offsets[Column(matrix.rows.size() - border)];
      const Eigen::Index size = A.rows() - inside;
      Eigen::MatrixXd S = A.bottomRightCorner(size, size);
      if (inside > 0) {
        S -= A.bottomLeftCorner(size, inside) * A.topLeftCorner(inside, inside).llt().solve(A.topRightCorner(inside, size));
      }
      const Eigen::MatrixXd lower = (cholesky.schur_complement() - S).triangularView<Eigen::Lower>();
      EXPECT_LT(lower.norm(), 1e-12 * S.norm()) << side << " " << border;

      Eigen::MatrixXd B(A.rows(), 2);
      for (auto& entry : B.reshaped()) entry = random.uniform(-1.0, 1.0);
      Eigen::MatrixXd X = cholesky.solve_lower(B);
      X.bottomRows(size) = S.llt().solve(X.bottomRows(size));
      EXPECT_LT((cholesky.solve_upper(X) - A.llt().solve(B)).norm(), 1e-12 * B.norm()) << side << " " << border;
    }
  }
}

TEST(SparseCholesky, TakesFrontsThatAreMadeWhenTheirTurnComes) {
  Random random;
  const testing::CoupledByFronts given(random);
  SparseCholesky cholesky;
  cholesky.analyse(given.pattern, given.fronts);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(9, -1.0, 2.0);
  for (int time = 0; time < 2; ++time) {
    ASSERT_TRUE(cholesky.factorise(given.pattern, given.fronts).empty());
    EXPECT_LT((given.A * cholesky.solve(b) - b).norm(), 1e-12 * b.norm());
  }
}

TEST(SparseCholesky, SolvesSystemsOfBlocksLikeTheDenseOne) {
  Random random;
  for (const int side : {1, 2, 7, 25}) {
    const BlockLower matrix = grid_system(side, random);
    const Eigen::MatrixXd A = dense(matrix);
    SparseCholesky cholesky;
    cholesky.analyse(matrix);
    ASSERT_TRUE(cholesky.factorise(matrix).empty()) << side;
    Eigen::MatrixXd B(A.rows(), 3);
    for (auto& entry : B.reshaped()) entry = random.uniform(-1.0, 1.0);
    EXPECT_LT((cholesky.solve_columns(B) - A.llt().solve(B)).norm(), 1e-12 * B.norm()) << side;
  }
}

TEST(SparseCholesky, FactorisesWideFrontsByTiles) {
  // One front of 450 columns: three tiles, the last one narrow.
  Random random;
  Eigen::MatrixXd A = 450.0 * Eigen::MatrixXd::Identity(450, 450);
  for (Eigen::Index j = 0; j < 450; ++j) {
    for (Eigen::Index i = 0; i < j; ++i) A(i, j) = A(j, i) = random.uniform(-1.0, 1.0);
  }
  const BlockLower matrix = sparse(A, std::vector<Eigen::Index>(150, 3));
  SparseCholesky cholesky;
  cholesky.analyse(matrix);
  ASSERT_TRUE(cholesky.factorise(matrix).empty());
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(450, -1.0, 2.0);
  EXPECT_LT((cholesky.solve(b) - A.llt().solve(b)).norm(), 1e-12 * b.norm());
}

TEST(SparseCholesky, IsTheSameToTheLastBitWithItsFactorInAFile) {
  Random random;
  const BlockLower matrix = grid_system(40, random);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(matrix.size(), -1.0, 2.0);
  const testing::TemporaryFolder folder;
  SparseCholesky in_memory;
  SparseCholesky in_file(0, folder.path());
  for (SparseCholesky* cholesky : {&in_memory, &in_file}) {
    cholesky->analyse(matrix);
    for (int time = 0; time < 2; ++time) ASSERT_TRUE(cholesky->factorise(matrix).empty());
  }
  EXPECT_EQ(in_file.solve(b), in_memory.solve(b));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SparseCholesky, SaysWhereItsFactorCannotBe) {
  Random random;
  const BlockLower matrix = grid_system(2, random);
  SparseCholesky cholesky(0, "/no/such/folder");
  cholesky.analyse(matrix);
  EXPECT_THROW(cholesky.make_room(), std::system_error);
}

TEST(SparseCholesky, IsTheSameToTheLastBitForAnyNumberOfThreads) {
  Random random;
  const BlockLower matrix = grid_system(90, random);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(matrix.size(), -1.0, 2.0);
  const auto solved_by = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    SparseCholesky cholesky;
    cholesky.analyse(matrix);
    EXPECT_TRUE(cholesky.factorise(matrix).empty());
    return cholesky.solve(b);
  };
  const Eigen::VectorXd x = solved_by(1);
  for (const std::size_t threads : {2u, 3u, 4u}) EXPECT_TRUE(solved_by(threads) == x) << threads;
}

TEST(SparseCholesky, NamesAllSingularColumns) {
  Random random;
  BlockLower matrix = grid_system(60, random);
  for (const int block : {3100, 900, 2000}) matrix.panel(Column(block))(1, 1) = -1.0;
  SparseCholesky cholesky;
  cholesky.analyse(matrix);
  const std::vector<std::int64_t> columns{matrix.offsets[900] + 1, matrix.offsets[2000] + 1, matrix.offsets[3100] + 1};
  for (int k = 0; k < 20; ++k) EXPECT_EQ(cholesky.factorise(matrix), columns);
}

TEST(SparseCholesky, TakesNewValuesInTheSamePattern) {
  Random random;
  Eigen::MatrixXd A = random_matrix(30, random);
  SparseCholesky cholesky;
  cholesky.analyse(sparse(A));
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(30);
  for (int k = 0; k < 3; ++k) {
    A.diagonal() *= 1.5;
    ASSERT_TRUE(cholesky.factorise(sparse(A)).empty());
    EXPECT_LT((A * cholesky.solve(b) - b).norm(), 1e-10);
  }
}

TEST(SparseCholesky, NamesTheColumnWhosePivotIsZero) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(6, 6);
  A(3, 3) = 0.0;
  SparseCholesky cholesky;
  cholesky.analyse(sparse(A));
  EXPECT_EQ(cholesky.factorise(sparse(A)), std::vector<std::int64_t>{3});
}

TEST(SparseCholesky, NamesAColumnThatHasLostItsDigitsToCancellation) {
  // Columns 2 and 4 are multiples of each other but for rounding.
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(6, 6);
  A(2, 2) = 0.1 * 0.1 * 1e6;
  A(2, 4) = A(4, 2) = 0.1 * 0.3 * 1e6;
  A(4, 4) = 0.3 * 0.3 * 1e6 * (1.0 + 1e-15);
  SparseCholesky cholesky;
  cholesky.analyse(sparse(A));
  EXPECT_EQ(cholesky.factorise(sparse(A)), std::vector<std::int64_t>{4});
}

TEST(SparseCholesky, APivotHasLostItsDigitsBelowAHundredTrillionthOfItsDiagonal) {
  for (const auto& [left, is_singular] : {std::pair{5e-15, true}, {2e-14, false}}) {
    Eigen::MatrixXd A = Eigen::MatrixXd::Identity(4, 4);
    A(1, 3) = A(3, 1) = 1.0;
    A(3, 3) = 1.0 + left;  // leaves a pivot of `left`
    SparseCholesky cholesky;
    cholesky.analyse(sparse(A));
    EXPECT_EQ(!cholesky.factorise(sparse(A)).empty(), is_singular) << left;
  }
}

TEST(SparseCholesky, IsFitForUseAgainAfterASingularMatrix) {
  Random random;
  const Eigen::MatrixXd A = random_matrix(40, random);
  Eigen::MatrixXd singular = A;
  singular(20, 20) = 0.0;
  SparseCholesky cholesky;
  cholesky.analyse(sparse(A));
  EXPECT_FALSE(cholesky.factorise(sparse(singular)).empty());
  ASSERT_TRUE(cholesky.factorise(sparse(A)).empty());
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(40);
  EXPECT_LT((A * cholesky.solve(b) - b).norm(), 1e-10);
}

TEST(SparseCholesky, StartsNoThreadsButThoseItIsAllowed) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  Random random;
  const Eigen::MatrixXd A = random_matrix(400, random);
  const BlockLower matrix = sparse(A);
  const auto factorise = [&] {
    SparseCholesky cholesky;
    const std::ptrdiff_t before = testing::threads_of("self");
    cholesky.analyse(matrix);
    ASSERT_TRUE(cholesky.factorise(matrix).empty());
    cholesky.solve(Eigen::VectorXd::Ones(400));
    EXPECT_LE(testing::threads_of("self"), before);
  };
  factorise();
  std::thread(factorise).join();
}

}  // namespace
}  // namespace mapjoin
