// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <memory>
#include <tests/lib/solve/rings_fixture.hpp>
#include <tests/support/sparse.hpp>

namespace mapjoin {
namespace {

using testing::Random;

class MarginalsTest : public testing::RingsTest {};

TEST_P(MarginalsTest, AreTheBlocksOfTheDenseInverse) {
  ASSERT_FALSE(equations.factorise(0.0));
  const Marginals marginals(equations);
  for (const Variable v : equations.variables()) {
    EXPECT_LT((marginals[v] - inverse_over({v})).norm(), 1e-12 * inverse_over({v}).norm()) << v.value;
    const std::vector<Variable> pair = {on_ring(v.value, 1, 1), v};
    EXPECT_LT((marginals.joint(pair) - inverse_over(pair)).norm(), 1e-12 * inverse_over(pair).norm()) << v.value;
  }
}

TEST_P(MarginalsTest, StayWhereTheyAreWhenTheEquationsGo) {
  ASSERT_FALSE(equations.factorise(0.0));
  const std::vector<Variable> pair = {on_ring(0, 1, 1), 0};
  auto going = std::make_unique<NormalEquations>(std::move(equations));
  const Marginals marginals(*going);
  const Eigen::MatrixXd before = marginals.joint(pair);
  going.reset();
  EXPECT_EQ(marginals.joint(pair), before);
}

TEST_P(MarginalsTest, TheLeastCurvatureIsTheMahalanobisLengthUnderTheJointCovarianceOfWhatIsGiven) {
  Eigen::VectorXd v(equations.size());
  for (auto& entry : v) entry = random.uniform(-1.0, 1.0);
  for (const int every : {1, 2, 5}) {
    std::vector<Variable> given;
    Table<Variable, bool> is_given(equations.variables().size());
    for (int k = 0; k < count; k += every) given.emplace_back(k);
    for (const Variable k : given) is_given[k] = true;
    const Eigen::VectorXd part = v(entries(given));
    const double expected = part.dot(inverse_over(given).ldlt().solve(part));
    EXPECT_NEAR(equations.least_curvature(v, is_given).value(), expected, 1e-10 * expected) << every;
  }
}

INSTANTIATE_TEST_SUITE_P(Variables, MarginalsTest, testing::kRings, testing::name_of_rings);

/// The information matrix of `count` random observations, each of three columns at most `reach` apart.
Eigen::MatrixXd random_matrix(Eigen::Index n, Eigen::Index count, Eigen::Index reach, Random& random) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index k = 0; k < count; ++k) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    const Eigen::Index i = k % n;
    for (const Eigen::Index j : {i, i + 1, i + 1 + k % reach}) row[j % n] = random.uniform(-1.0, 1.0);
    A += row * row.transpose();
  }
  return A;
}

struct Case {
  Eigen::Index size;
  Eigen::Index observations;
  Eigen::Index reach;
};

class InverseSubsetTest : public ::testing::TestWithParam<Case> {};

TEST_P(InverseSubsetTest, HoldsTheEntriesOfTheDenseInverseWhereTheMatrixHasSome) {
  Random random;
  const Eigen::MatrixXd A = random_matrix(GetParam().size, GetParam().observations, GetParam().reach, random);
  SparseCholesky cholesky;
  const BlockLower matrix = testing::sparse(A);
  cholesky.analyse(matrix);
  ASSERT_TRUE(cholesky.factorise(matrix).empty());
  const InverseSubset subset(cholesky.supernodes());
  const Eigen::MatrixXd inverse = A.inverse();
  double largest = 0.0;
  for (std::int64_t j = 0; j < A.cols(); ++j) {
    for (std::int64_t i = 0; i <= j; ++i) {
      if (A(i, j) == 0.0) continue;
      const std::vector<std::int64_t> columns = i == j ? std::vector{j} : std::vector{j, i};
      const Eigen::MatrixXd block = subset.block(columns);
      const Eigen::MatrixXd expected = inverse(columns, columns);
      largest = std::max(largest, (block - expected).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_LT(largest, 1e-11 * inverse.cwiseAbs().maxCoeff());
}
// Cases from factors kept column by column to those of wide supernodes.
INSTANTIATE_TEST_SUITE_P(Sizes, InverseSubsetTest,
                         ::testing::Values(Case{1, 0, 1}, Case{2, 4, 1}, Case{50, 60, 3}, Case{200, 600, 9},
                                           Case{300, 1500, 290}, Case{250, 9000, 240}),
                         [](const auto& info) { return std::to_string(info.index); });

TEST(InverseSubset, KeepsTheOrderOfTheColumnsAskedFor) {
  Random random;
  const Eigen::MatrixXd A = random_matrix(30, 3000, 29, random);
  const BlockLower matrix = testing::sparse(A);
  SparseCholesky cholesky;
  cholesky.analyse(matrix);
  ASSERT_TRUE(cholesky.factorise(matrix).empty());
  const std::vector<std::int64_t> columns = {17, 3, 29, 0};
  const Eigen::MatrixXd expected = A.inverse()(columns, columns);
  EXPECT_LT((InverseSubset(cholesky.supernodes()).block(columns) - expected).norm(), 1e-12 * expected.norm());
}

TEST(InverseSubset, RefusesWhatIsNotCoupled) {
  SparseCholesky cholesky;
  const BlockLower matrix = testing::sparse(Eigen::MatrixXd::Identity(4, 4));
  cholesky.analyse(matrix);
  ASSERT_TRUE(cholesky.factorise(matrix).empty());
  const InverseSubset subset(cholesky.supernodes());
  const std::vector<std::int64_t> columns = {1, 2};
  EXPECT_THROW(subset.block(columns), std::out_of_range);
}

TEST(InverseSubset, CountsItsMemoryBeforehand) {
  Random random;
  const BlockLower matrix = testing::sparse(random_matrix(200, 9000, 190, random));
  SparseCholesky cholesky;
  cholesky.analyse(matrix);
  ASSERT_TRUE(cholesky.factorise(matrix).empty());
  // A nearly dense matrix takes its lower triangle at least, and not many times its square.
  EXPECT_GT(InverseSubset::bytes(cholesky.supernodes()), 8 * 200 * 200 / 2);
  EXPECT_LT(InverseSubset::bytes(cholesky.supernodes()), 8 * 200 * 200 * 4);
}

}  // namespace
}  // namespace mapjoin
