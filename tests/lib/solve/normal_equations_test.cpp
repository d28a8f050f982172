// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Cholesky>
#include <array>
#include <mapjoin/solve/normal_equations.hpp>
#include <optional>
#include <tests/support/random.hpp>
#include <utility>

namespace mapjoin {
namespace {

using testing::Random;

/// Normal equations over variables of 3 and of 2 entries in random factors, and the dense matrix of the same blocks.
class NormalEquationsTest : public ::testing::Test {
 protected:
  void make(int triples, int pairs, int count) {
    BlockPattern pattern;
    pattern.dofs.assign(static_cast<std::size_t>(triples), 3);
    pattern.dofs.resize(static_cast<std::size_t>(triples + pairs), 2);
    const int variables = triples + pairs;
    for (int c = 0; c < count; ++c) {
      const int a = static_cast<int>(random.uniform(0.0, variables - 1e-9));
      const int b = (a + 1 + c % (variables - 1)) % variables;
      const Variable third = c % 4 == 0 ? kConstant : Variable(other_than(a, b, variables));
      pattern.factors.push_back(std::array{Variable(a), Variable(b), third});
    }
    make(pattern);
  }
  static int other_than(int a, int b, int variables) {
    int v = 0;
    while (v == a || v == b) ++v;
    return v % variables;
  }

  void make(const BlockPattern& pattern) {
    equations = NormalEquations(pattern);
    const Eigen::Index n = equations.size();
    H = Eigen::MatrixXd::Zero(n, n);
    g = Eigen::VectorXd::Zero(n);
    equations.set_zero();
    for (std::size_t f = 0; f < pattern.factors.size(); ++f) add(pattern.factors[f], equations.sink(f));
  }

  /// Adds JᵀJ and Jᵀr of a random J over the variables of a factor: to the sink the blocks of variables i ≤ j, to H all.
  void add(std::span<const Variable> variables, NormalEquations::Sink sink) {
    std::vector<Eigen::MatrixXd> J;
    const Eigen::VectorXd r = random.vector<6>();
    for (const Variable v : variables) {
      const int dof = v == kConstant ? 2 : equations.dof(v);
      Eigen::MatrixXd block(6, dof);
      for (auto& entry : block.reshaped()) entry = random.uniform(-1.0, 1.0);
      J.push_back(block);
    }
    for (std::size_t j = 0; j < variables.size(); ++j) {
      sink.rhs(static_cast<int>(j), Eigen::VectorXd(J[j].transpose() * r));
      if (variables[j] != kConstant) g.segment(equations.offset(variables[j]), J[j].cols()) += J[j].transpose() * r;
      for (std::size_t i = 0; i < variables.size(); ++i) {
        const Eigen::MatrixXd block = J[i].transpose() * J[j];
        if (i <= j) sink.hessian(static_cast<int>(i), static_cast<int>(j), block);
        if (variables[i] == kConstant || variables[j] == kConstant) continue;
        H.block(equations.offset(variables[i]), equations.offset(variables[j]), block.rows(), block.cols()) += block;
      }
    }
  }

  Random random;
  NormalEquations equations{{}};
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
  BlockPattern pattern{{3, 3, 2, 2}, {}};
  pattern.factors.push_back(std::array<Variable, 2>{0, 1});
  pattern.factors.push_back(std::array<Variable, 2>{1, 3});
  make(pattern);
  EXPECT_EQ(equations.factorise(0.0), Variable(2));  // which is in no factor
}

TEST(LoneTies, AreTheFactorsWithoutWhichVariablesFallApart) {
  BlockPattern pattern{{3, 3, 3, 3, 3, 2}, {}};
  const auto add = [&](auto... variables) { pattern.factors.push_back(std::array{Variable(variables)...}); };
  add(kConstant.value, 0);
  add(0, 1);
  add(1, kConstant.value);  // which closes a cycle
  add(1, 2);
  add(2, 3);
  add(3, 4, 5);
  add(4, 5);  // which closes another
  EXPECT_EQ(lone_ties(pattern), (std::vector<bool>{false, false, false, true, true, false, false}));
}

/// The pattern of a chain of poses that see features of a strip beside it.
BlockPattern strip(int poses, int features) {
  BlockPattern pattern;
  pattern.dofs.assign(static_cast<std::size_t>(poses), 3);
  pattern.dofs.resize(static_cast<std::size_t>(poses + features), 2);
  const auto add = [&](auto... variables) { pattern.factors.push_back(std::array{Variable(variables)...}); };
  for (int p = 0; p < poses; ++p) {
    if (p > 0) add(p - 1, p);
    for (int k = 0; k < 3; ++k) add(p, poses + (p * features / poses + k) % features);
    if (p % 5 == 0) add(p, poses + p % features, (p + 7) % poses);
    if (p % 10 == 0) add((p + 11) % poses, p, poses);
    if (p % 90 == 0) add(kConstant.value, p);
  }
  return pattern;
}

TEST_F(NormalEquationsTest, AreTheSameFromAllThreadsAsOneByOne) {
  const BlockPattern pattern = strip(1500, 200);
  const auto fill_one = [&](std::size_t factor, NormalEquations::Sink sink) {
    const auto variables = pattern.factors[factor];
    Random of_factor(static_cast<unsigned>(factor));
    const auto dof = [&](int i) {
      const Variable v = variables[static_cast<std::size_t>(i)];
      return v == kConstant ? 3 : pattern.dofs[v];
    };
    for (int j = 0; j < static_cast<int>(variables.size()); ++j) {
      sink.rhs(j, Eigen::VectorXd::Constant(dof(j), of_factor.uniform(-1.0, 1.0)).eval());
      for (int i = 0; i <= j; ++i) {
        sink.hessian(i, j, Eigen::MatrixXd::Constant(dof(i), dof(j), of_factor.uniform(-1.0, 1.0)).eval());
      }
    }
    return 1.0;
  };
  NormalEquations one_by_one(pattern);
  one_by_one.set_zero();
  for (std::size_t f = 0; f < pattern.factors.size(); ++f) fill_one(f, one_by_one.sink(f));
  const Eigen::VectorXd v = Eigen::VectorXd::LinSpaced(one_by_one.size(), -1.0, 1.0);

  std::optional<std::pair<Eigen::VectorXd, double>> first;
  for (const std::size_t threads : {1u, 2u, 4u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    NormalEquations together(pattern);
    together.set_zero();
    EXPECT_EQ(together.accumulate_factors(fill_one), static_cast<double>(pattern.factors.size()));
    EXPECT_LT((together.gradient() - one_by_one.gradient()).norm(), 1e-13 * one_by_one.gradient().norm());
    EXPECT_LT((together.diagonal() - one_by_one.diagonal()).norm(), 1e-13 * one_by_one.diagonal().norm());
    EXPECT_NEAR(together.curvature(v), one_by_one.curvature(v), 1e-11);
    const auto sums = std::pair{Eigen::VectorXd(together.gradient()), together.curvature(v)};
    if (!first) first = sums;
    EXPECT_TRUE(sums.first == first->first && sums.second == first->second) << threads;
  }
}

TEST_F(NormalEquationsTest, MayHaveNoVariables) {
  BlockPattern pattern;
  pattern.factors.push_back(std::array{kConstant, kConstant});
  make(pattern);
  EXPECT_EQ(equations.size(), 0);
  EXPECT_FALSE(equations.factorise(0.0));
  EXPECT_EQ(equations.solve(g).size(), 0);
}

}  // namespace
}  // namespace mapjoin
