// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <filesystem>
#include <iterator>
#include <mapjoin/solve/dense_kernels.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>
#include <tests/support/random.hpp>
#include <tests/support/sparse.hpp>
#include <thread>

namespace mapjoin {
namespace {

using testing::Random;
using testing::sparse;

/// A banded positive definite matrix with a few far couplings; `large` ones are factorised by supernodes.
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
    ASSERT_FALSE(cholesky.factorise(matrix)) << n;
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(n, -1.0, 2.0);
    EXPECT_LT((A * cholesky.solve(b) - b).norm(), 1e-10 * b.norm()) << n;
  }
}

TEST(SparseCholesky, TakesNewValuesInTheSamePattern) {
  Random random;
  Eigen::MatrixXd A = random_matrix(30, random);
  SparseCholesky cholesky;
  cholesky.analyse(sparse(A));
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(30);
  for (int k = 0; k < 3; ++k) {
    A.diagonal() *= 1.5;
    ASSERT_FALSE(cholesky.factorise(sparse(A)));
    EXPECT_LT((A * cholesky.solve(b) - b).norm(), 1e-10);
  }
}

TEST(SparseCholesky, NamesTheColumnWhosePivotIsZero) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(6, 6);
  A(3, 3) = 0.0;
  SparseCholesky cholesky;
  cholesky.analyse(sparse(A));
  EXPECT_EQ(cholesky.factorise(sparse(A)), 3);
}

TEST(SparseCholesky, NamesAColumnThatHasLostItsDigitsToCancellation) {
  // Columns 2 and 4 measure the same thing: exactly singular but for rounding.
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(6, 6);
  A(2, 2) = 0.1 * 0.1 * 1e6;
  A(2, 4) = A(4, 2) = 0.1 * 0.3 * 1e6;
  A(4, 4) = 0.3 * 0.3 * 1e6 * (1.0 + 1e-15);
  SparseCholesky cholesky;
  cholesky.analyse(sparse(A));
  EXPECT_EQ(cholesky.factorise(sparse(A)), 4);
}

TEST(SparseCholesky, IsFitForUseAgainAfterASingularMatrix) {
  Random random;
  const Eigen::MatrixXd A = random_matrix(40, random);
  Eigen::MatrixXd singular = A;
  singular(20, 20) = 0.0;
  SparseCholesky cholesky;
  cholesky.analyse(sparse(A));
  EXPECT_TRUE(cholesky.factorise(sparse(singular)));
  ASSERT_FALSE(cholesky.factorise(sparse(A)));
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(40);
  EXPECT_LT((A * cholesky.solve(b) - b).norm(), 1e-10);
}

std::ptrdiff_t threads_of_this_process() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

TEST(SparseCholesky, StartsNoThreadsWhicheverThreadCallsIt) {
  Random random;
  const Eigen::MatrixXd A = random_matrix(400, random);
  const BlockLower matrix = sparse(A);
  const auto factorise = [&] {
    SparseCholesky cholesky;
    const std::ptrdiff_t before = threads_of_this_process();
    cholesky.analyse(matrix);
    ASSERT_FALSE(cholesky.factorise(matrix));
    cholesky.solve(Eigen::VectorXd::Ones(400));
    EXPECT_EQ(threads_of_this_process(), before);
  };
  factorise();
  std::thread(factorise).join();
}

TEST(SparseCholesky, NamesTheBlasForTheReport) {
  EXPECT_FALSE(blas_name().empty());
}

}  // namespace
}  // namespace mapjoin
