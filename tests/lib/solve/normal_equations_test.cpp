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

/// A chain of poses that see features of a strip beside it; more cliques of three have the first feature than have colours.
Cliques strip(Index poses, Index features) {
  Cliques cliques;
  for (Index p = 0; p < poses; ++p) {
    if (p > 0) cliques.push_back(std::array{p - 1, p});
    for (Index k = 0; k < 3; ++k) cliques.push_back(std::array{p, poses + (p * features / poses + k) % features});
    if (p % 5 == 0) cliques.push_back(std::array{p, poses + p % features, (p + 7) % poses});
    if (p % 10 == 0) cliques.push_back(std::array{(p + 11) % poses, p, poses});
    if (p % 90 == 0) cliques.push_back(std::array{kConstant, p});
  }
  return cliques;
}

TEST_F(NormalEquationsTest, AreTheSameFromAllThreadsAsOneByOne) {
  const Index poses = 1500;
  const Index features = 200;
  std::vector<int> dofs(poses, 3);
  dofs.resize(poses + features, 2);
  const Cliques cliques = strip(poses, features);
  const auto fill_one = [&](std::size_t clique, NormalEquations::Sink sink) {
    const auto slots = cliques[clique];
    Random of_clique(static_cast<unsigned>(clique));
    for (int j = 0; j < static_cast<int>(slots.size()); ++j) {
      const Index b = slots[static_cast<std::size_t>(j)];
      const int cols = b == kConstant ? 3 : dofs[static_cast<std::size_t>(b)];
      sink.rhs(j, Eigen::VectorXd::Constant(cols, of_clique.uniform(-1.0, 1.0)).eval());
      for (int i = 0; i <= j; ++i) {
        const Index a = slots[static_cast<std::size_t>(i)];
        const int rows = a == kConstant ? 3 : dofs[static_cast<std::size_t>(a)];
        sink.hessian(i, j, Eigen::MatrixXd::Constant(rows, cols, of_clique.uniform(-1.0, 1.0)).eval());
      }
    }
    return 1.0;
  };
  NormalEquations one_by_one(dofs, cliques);
  one_by_one.set_zero();
  for (std::size_t c = 0; c < cliques.size(); ++c) fill_one(c, one_by_one.sink(c));
  const Eigen::VectorXd v = Eigen::VectorXd::LinSpaced(one_by_one.size(), -1.0, 1.0);

  std::optional<std::pair<Eigen::VectorXd, double>> first;
  for (const std::size_t threads : {1u, 2u, 4u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    NormalEquations together(dofs, cliques);
    together.set_zero();
    EXPECT_EQ(together.accumulate_cliques(fill_one), static_cast<double>(cliques.size()));
    EXPECT_LT((together.gradient() - one_by_one.gradient()).norm(), 1e-13 * one_by_one.gradient().norm());
    EXPECT_LT((together.diagonal() - one_by_one.diagonal()).norm(), 1e-13 * one_by_one.diagonal().norm());
    EXPECT_NEAR(together.curvature(v), one_by_one.curvature(v), 1e-11);
    const auto sums = std::pair{Eigen::VectorXd(together.gradient()), together.curvature(v)};
    if (!first) first = sums;
    EXPECT_TRUE(sums.first == first->first && sums.second == first->second) << threads;
  }
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
