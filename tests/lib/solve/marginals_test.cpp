// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <mapjoin/solve/marginals.hpp>
#include <mapjoin/solve/memory.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::Random;

/// Variables of 3 and of 2 entries by turns in a ring of observations of three, with some across; the same blocks also go into
/// a dense matrix.
class MarginalsTest : public ::testing::TestWithParam<Index> {
 protected:
  MarginalsTest() {
    const Index count = GetParam();
    std::vector<int> dofs;
    for (Index v = 0; v < count; ++v) dofs.push_back(v % 2 == 0 ? 3 : 2);
    for (Index v = 0; v < count; ++v) cliques.push_back(std::array{v, (v + 1) % count, (7 * v + 3) % count});
    equations = NormalEquations(dofs, cliques);
    H = Eigen::MatrixXd::Zero(equations.size(), equations.size());
    equations.set_zero();
    for (std::size_t c = 0; c < cliques.size(); ++c) add_observation(c);
    inverse = H.inverse();
  }

  void add_observation(std::size_t clique) {
    const auto slots = cliques[clique];
    auto sink = equations.sink(clique);
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i <= j; ++i) {
        const Index a = slots[static_cast<std::size_t>(i)];
        const Index b = slots[static_cast<std::size_t>(j)];
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
  std::vector<Eigen::Index> entries(const std::vector<Index>& variables) const {
    std::vector<Eigen::Index> list;
    for (const Index v : variables) {
      for (int i = 0; i < equations.dof(v); ++i) list.push_back(equations.offset(v) + i);
    }
    return list;
  }
  Eigen::MatrixXd inverse_over(const std::vector<Index>& variables) const {
    return inverse(entries(variables), entries(variables));
  }

  Random random;
  Cliques cliques;
  NormalEquations equations{{}, {}};
  Eigen::MatrixXd H;
  Eigen::MatrixXd inverse;
};

TEST_P(MarginalsTest, AreTheBlocksOfTheDenseInverse) {
  ASSERT_FALSE(equations.factorise(0.0));
  const Marginals marginals(equations);
  for (Index v = 0; v < GetParam(); ++v) {
    EXPECT_LT((marginals[v] - inverse_over({v})).norm(), 1e-12 * inverse_over({v}).norm()) << v;
    const std::vector<Index> pair = {(v + 1) % GetParam(), v};
    EXPECT_LT((marginals.joint(pair) - inverse_over(pair)).norm(), 1e-12 * inverse_over(pair).norm()) << v;
  }
}

TEST_P(MarginalsTest, UnitColumnsGiveTheJointCovarianceOfVariablesFarApart) {
  ASSERT_FALSE(equations.factorise(0.0));
  const std::vector<Index> variables = {GetParam() - 1, 0, GetParam() / 2};
  const auto list = entries(variables);
  Eigen::SparseMatrix<double> units(equations.size(), static_cast<Eigen::Index>(list.size()));
  for (std::size_t k = 0; k < list.size(); ++k) units.insert(list[k], static_cast<Eigen::Index>(k)) = 1.0;
  const Eigen::MatrixXd expected = inverse_over(variables);
  EXPECT_LT((covariance_of(equations, units) - expected).norm(), 1e-12 * expected.norm());
}

TEST_P(MarginalsTest, TheLeastCurvatureIsTheMahalanobisLengthUnderTheJointCovarianceOfWhatIsGiven) {
  Eigen::VectorXd v(equations.size());
  for (auto& entry : v) entry = random.uniform(-1.0, 1.0);
  for (const Index every : {1, 2, 5}) {
    std::vector<Index> given;
    std::vector<bool> is_given(static_cast<std::size_t>(GetParam()));
    for (Index k = 0; k < GetParam(); k += every) given.push_back(k);
    for (const Index k : given) is_given[static_cast<std::size_t>(k)] = true;
    const Eigen::VectorXd part = v(entries(given));
    const double expected = part.dot(inverse_over(given).ldlt().solve(part));
    EXPECT_NEAR(equations.least_curvature(v, is_given).value(), expected, 1e-10 * expected) << every;
  }
}
INSTANTIATE_TEST_SUITE_P(Variables, MarginalsTest, ::testing::Values(7, 40, 300));

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
