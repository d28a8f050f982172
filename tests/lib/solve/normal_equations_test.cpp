// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <mapjoin/solve/normal_equations.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::Random;

/// Variables of 3 and of 2 entries in random cliques; the same blocks also go into a dense matrix.
class NormalEquationsTest : public ::testing::Test {
 protected:
  void make(Index triples, Index pairs, int count) {
    std::vector<int> dofs(static_cast<std::size_t>(triples), 3);
    dofs.resize(static_cast<std::size_t>(triples + pairs), 2);
    const Index variables = triples + pairs;
    Cliques cliques;
    const auto any = [&] { return static_cast<Index>(random.uniform(0.0, variables - 1e-9)); };
    for (int c = 0; c < count; ++c) {
      const Index a = any();
      const Index b = (a + 1 + c % (variables - 1)) % variables;
      cliques.push_back(std::array{a, b, c % 4 == 0 ? kConstant : other_than(a, b, variables)});
    }
    equations = NormalEquations(dofs, cliques);
    fill(dofs, cliques);
  }
  static Index other_than(Index a, Index b, Index variables) {
    Index v = 0;
    while (v == a || v == b) ++v;
    return v % variables;
  }

  void fill(const std::vector<int>& dofs, const Cliques& cliques) {
    const Eigen::Index n = equations.size();
    H = Eigen::MatrixXd::Zero(n, n);
    g = Eigen::VectorXd::Zero(n);
    equations.set_zero();
    for (std::size_t c = 0; c < cliques.size(); ++c) add(cliques[c], dofs, equations.sink(c));
  }

  /// JᵀJ and Jᵀr of a random J over the slots of a clique, blocks of slots i ≤ j.
  void add(std::span<const Index> slots, const std::vector<int>& dofs, NormalEquations::Sink sink) {
    std::vector<Eigen::MatrixXd> J;
    const Eigen::VectorXd r = random.vector<6>();
    for (const Index v : slots) {
      const int dof = v == kConstant ? 2 : dofs[static_cast<std::size_t>(v)];
      Eigen::MatrixXd block(6, dof);
      for (auto& entry : block.reshaped()) entry = random.uniform(-1.0, 1.0);
      J.push_back(block);
    }
    for (std::size_t j = 0; j < slots.size(); ++j) {
      sink.rhs(static_cast<int>(j), Eigen::VectorXd(J[j].transpose() * r));
      if (slots[j] != kConstant) g.segment(equations.offset(slots[j]), J[j].cols()) += J[j].transpose() * r;
      for (std::size_t i = 0; i < slots.size(); ++i) {
        const Eigen::MatrixXd block = J[i].transpose() * J[j];
        if (i <= j) sink.hessian(static_cast<int>(i), static_cast<int>(j), block);
        if (slots[i] == kConstant || slots[j] == kConstant) continue;
        H.block(equations.offset(slots[i]), equations.offset(slots[j]), block.rows(), block.cols()) += block;
      }
    }
  }

  Random random;
  NormalEquations equations{{}, {}};
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};

TEST_F(NormalEquationsTest, SolveLikeTheDenseSystem) {
  for (const auto& [triples, pairs, count] : {std::array{3, 2, 20}, {20, 30, 200}, {150, 150, 1200}}) {
    make(triples, pairs, count);
    ASSERT_FALSE(equations.factorise(0.0));
    EXPECT_LT((equations.gradient() - g).norm(), 1e-12 * g.norm());
    const Eigen::VectorXd expected = H.ldlt().solve(g);
    EXPECT_LT((equations.solve(g) - expected).norm(), 1e-8 * expected.norm()) << triples;
  }
}

TEST_F(NormalEquationsTest, CurvatureAndDiagonalAreThoseOfTheDenseMatrix) {
  make(20, 30, 200);
  EXPECT_LT((equations.diagonal() - H.diagonal()).norm(), 1e-12 * H.norm());
  const Eigen::VectorXd v = Eigen::VectorXd::LinSpaced(equations.size(), -1.0, 1.0);
  EXPECT_NEAR(equations.curvature(v), v.dot(H * v), 1e-11 * v.dot(H * v));
}

TEST_F(NormalEquationsTest, DampingScalesTheDiagonalForOneFactorisation) {
  make(20, 30, 200);
  ASSERT_FALSE(equations.factorise(0.5));
  Eigen::MatrixXd damped = H;
  damped.diagonal() *= 1.5;
  EXPECT_LT((equations.solve(g) - damped.llt().solve(g)).norm(), 1e-10 * g.norm());
  ASSERT_FALSE(equations.factorise(0.0));
  const Eigen::VectorXd expected = H.ldlt().solve(g);
  EXPECT_LT((equations.solve(g) - expected).norm(), 1e-8 * expected.norm());
}

TEST_F(NormalEquationsTest, NameTheVariableThatNothingDetermines) {
  Cliques cliques;
  cliques.push_back(std::array<Index, 2>{0, 1});
  cliques.push_back(std::array<Index, 2>{1, 3});
  const std::vector<int> dofs{3, 3, 2, 2};
  equations = NormalEquations(dofs, cliques);
  fill(dofs, cliques);
  EXPECT_EQ(equations.factorise(0.0), 2);  // no clique mentions it
}

TEST_F(NormalEquationsTest, MayHaveNoVariables) {
  Cliques cliques;
  cliques.push_back(std::array{kConstant, kConstant});
  equations = NormalEquations({}, cliques);
  fill({}, cliques);
  EXPECT_EQ(equations.size(), 0);
  EXPECT_FALSE(equations.factorise(0.0));
  EXPECT_EQ(equations.solve(g).size(), 0);
}

}  // namespace
}  // namespace mapjoin
