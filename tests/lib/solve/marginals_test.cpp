// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <mapjoin/solve/marginals.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>
#include <tests/support/random.hpp>
#include <tests/support/sparse.hpp>

namespace mapjoin {
namespace {

using testing::Random;

struct Rings {
  int variables;
  int rings;
  Engine engine = Engine::kFronts;
};

/// Variables of 3 and of 2 entries in rings, which nothing ties to each other, of observations of three, with some across; the
/// same blocks also go into a dense matrix.
class MarginalsTest : public ::testing::TestWithParam<Rings> {
 protected:
  MarginalsTest() {
    BlockPattern pattern;
    for (int v = 0; v < count; ++v) pattern.dofs.push_back(v % 2 == 0 ? 3 : 2);
    for (int v = 0; v < count; ++v) pattern.factors.push_back(std::array{Variable(v), on_ring(v, 1, 1), on_ring(v, 7, 3)});
    equations = NormalEquations(pattern, GetParam().engine);
    H = Eigen::MatrixXd::Zero(equations.size(), equations.size());
    equations.set_zero();
    for (std::size_t f = 0; f < pattern.factors.size(); ++f) add_factor(f);
    inverse = H.inverse();
  }

  /// The variable at a·k + b of the ring that has v, v being the k-th of it.
  Variable on_ring(int v, int a, int b) const {
    const int rings = GetParam().rings;
    return Variable((a * (v / rings) + b) % (count / rings) * rings + v % rings);
  }
  void add_factor(std::size_t factor) {
    const auto variables = equations.pattern().factors[factor];
    auto sink = equations.sink(factor);
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i <= j; ++i) {
        const Variable a = variables[static_cast<std::size_t>(i)];
        const Variable b = variables[static_cast<std::size_t>(j)];
        if (a == b && i != j) continue;
        const Eigen::MatrixXd block = information(equations.dof(a), equations.dof(b), i == j);
        sink.hessian(i, j, block);
        H.block(equations.offset(a), equations.offset(b), block.rows(), block.cols()) += block;
        if (i != j) H.block(equations.offset(b), equations.offset(a), block.cols(), block.rows()) += block.transpose();
      }
    }
  }
  /// Diagonal blocks outweigh the others: H is positive definite.
  Eigen::MatrixXd information(int rows, int cols, bool is_diagonal) {
    if (is_diagonal) return 6.0 * Eigen::MatrixXd::Identity(rows, cols);
    Eigen::MatrixXd block(rows, cols);
    for (auto& entry : block.reshaped()) entry = random.uniform(-1.0, 1.0);
    return block;
  }
  std::vector<Eigen::Index> entries(const std::vector<Variable>& variables) const {
    std::vector<Eigen::Index> list;
    for (const Variable v : variables) {
      for (int i = 0; i < equations.dof(v); ++i) list.push_back(equations.offset(v) + i);
    }
    return list;
  }
  Eigen::MatrixXd inverse_over(const std::vector<Variable>& variables) const {
    return inverse(entries(variables), entries(variables));
  }

  const int count = GetParam().variables;
  Random random;
  NormalEquations equations{{}};
  Eigen::MatrixXd H;
  Eigen::MatrixXd inverse;
};

TEST_P(MarginalsTest, AreTheBlocksOfTheDenseInverse) {
  ASSERT_FALSE(equations.factorise(0.0));
  const Marginals marginals(equations);
  for (const Variable v : equations.variables()) {
    EXPECT_LT((marginals[v] - inverse_over({v})).norm(), 1e-12 * inverse_over({v}).norm()) << v.value;
    const std::vector<Variable> pair = {on_ring(v.value, 1, 1), v};
    EXPECT_LT((marginals.joint(pair) - inverse_over(pair)).norm(), 1e-12 * inverse_over(pair).norm()) << v.value;
  }
}

TEST_P(MarginalsTest, CrossCovariancesAreTheBlocksOfTheDenseInverse) {
  ASSERT_FALSE(equations.factorise(0.0));
  const CrossCovariances cross(equations);
  std::vector<Variable> all;
  for (const Variable v : equations.variables()) all.push_back(v);
  all.push_back(all.front());  // in any order, and more than once
  for (const std::vector<Variable>& rows : {std::vector<Variable>{0}, {Variable(count - 1), Variable(count / 2)}}) {
    const Eigen::MatrixXd of_all = inverse(entries(rows), entries(all));
    EXPECT_LT((cross.between(rows, all) - of_all).norm(), 1e-12 * of_all.norm());
    const double tolerance = 1e-12 * inverse_over(rows).norm();
    for (const Variable v : all) {
      const Eigen::MatrixXd expected = inverse(entries(rows), entries({v}));
      EXPECT_LT((cross.between(rows, {&v, 1}) - expected).norm(), tolerance) << rows.front().value << " and " << v.value;
    }
  }
}

TEST_P(MarginalsTest, CrossCovariancesGiveTheJointOneOfAnyVariables) {
  ASSERT_FALSE(equations.factorise(0.0));
  const CrossCovariances cross(equations);
  std::vector<Variable> all;
  for (const Variable v : equations.variables()) all.insert(all.begin(), v);
  for (const std::vector<Variable>& variables : {std::vector<Variable>{}, {Variable(count - 1), 0, 0}, all}) {
    const Eigen::MatrixXd expected = inverse_over(variables);
    const Eigen::MatrixXd joint = cross.joint(variables);
    ASSERT_EQ(joint.rows(), expected.rows());
    EXPECT_LE((joint - expected).norm(), 1e-12 * expected.norm());
    EXPECT_EQ(joint, joint.transpose());
  }
}

TEST_P(MarginalsTest, CrossCovariancesCountTheirMemoryBeforehand) {
  ASSERT_FALSE(equations.factorise(0.0));
  const CrossCovariances cross(equations);
  std::vector<Variable> all;
  for (const Variable v : equations.variables()) all.push_back(v);
  const std::int64_t of_result = 8 * equations.size() * equations.size();
  EXPECT_GT(cross.bytes(all), of_result + equations.factor_bytes() / equations.size());
  EXPECT_LT(cross.bytes(all), 40 * of_result);
  EXPECT_LT(cross.bytes({all.data(), 1}), cross.bytes(all));
  EXPECT_LT(cross.bytes({}), 100);
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
INSTANTIATE_TEST_SUITE_P(Variables, MarginalsTest,
                         ::testing::Values(Rings{7, 1}, Rings{40, 1}, Rings{300, 1}, Rings{60, 3},
                                           Rings{40, 1, Engine::kCholmod}, Rings{60, 3, Engine::kCholmod}),
                         [](const auto& info) {
                           return fmt::format("{}in{}by_{}", info.param.variables, info.param.rings,
                                              to_string(info.param.engine));
                         });

/// Of `count` random observations, each of three columns at most `reach` apart.
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
// From factors kept column by column to those of wide supernodes.
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
  // Nearly dense: the lower triangle at least, and not many times the square.
  EXPECT_GT(InverseSubset::bytes(cholesky.supernodes()), 8 * 200 * 200 / 2);
  EXPECT_LT(InverseSubset::bytes(cholesky.supernodes()), 8 * 200 * 200 * 4);
}

TEST(Memory, IsRefusedBeyondTheLimitInASentence) {
  EXPECT_TRUE(check_memory("the covariances", 1000, 1000));
  EXPECT_TRUE(check_memory("the covariances", 1000, 0));
  const auto refused = check_memory("the covariances", 3'000'000, 2'000'000);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kTooLarge);
  EXPECT_EQ(refused.error().message, "the covariances would take 3.0 MB of memory, more than the 2.0 MB allowed");
  EXPECT_FALSE(check_memory("the covariances", machine_memory() + 1, 0));
}

}  // namespace
}  // namespace mapjoin
