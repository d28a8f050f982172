// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

/// The same sum, dense.
class FrontTreeTest : public ::testing::Test {
 protected:
  Index add_variable(int dof) {
    dofs_.push_back(dof);
    return tree_.add_variable(dof);
  }

  Eigen::Index offset(Index v) const {
    Eigen::Index sum = 0;
    for (Index w = 0; w < v; ++w) sum += dofs_[static_cast<std::size_t>(w)];
    return sum;
  }

  Quadratic random_quadratic(std::vector<Index> variables) {
    Eigen::Index size = 0;
    for (const Index v : variables) size += dofs_[static_cast<std::size_t>(v)];
    Eigen::MatrixXd A(size, size);
    Eigen::VectorXd b(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      b[i] = random_.uniform(-1.0, 1.0);
      for (Eigen::Index j = 0; j < size; ++j) A(i, j) = random_.uniform(-1.0, 1.0);
    }
    return {std::move(variables), A * A.transpose() + Eigen::MatrixXd::Identity(size, size), b};
  }

  void add(std::vector<Index> variables) {
    quadratics_.push_back(random_quadratic(std::move(variables)));
    tree_.add_quadratic(quadratics_.back());
  }

  /// The largest difference between the tree's solution and that of the dense system, relative to the latter.
  double error() const {
    const auto count = static_cast<Index>(dofs_.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(offset(count), offset(count));
    Eigen::VectorXd b = Eigen::VectorXd::Zero(offset(count));
    for (const Quadratic& q : quadratics_) {
      std::vector<Eigen::Index> entries;
      for (const Index v : q.variables) {
        for (int i = 0; i < dofs_[static_cast<std::size_t>(v)]; ++i) entries.push_back(offset(v) + i);
      }
      H(entries, entries) += q.H;
      b(entries) += q.b;
    }
    const Eigen::VectorXd expected = H.llt().solve(b);
    double worst = 0.0;
    for (Index v = 0; v < count; ++v) {
      const Eigen::VectorXd found = tree_.solution(v);
      worst = std::max(worst, (found - expected.segment(offset(v), found.size())).cwiseAbs().maxCoeff());
    }
    return worst / expected.cwiseAbs().maxCoeff();
  }

  testing::Random random_{7};
  FrontTree tree_;
  std::vector<int> dofs_;
  std::vector<Quadratic> quadratics_;
};

TEST_F(FrontTreeTest, SolvesAGrowingChainWithClosuresAfterEveryUpdate) {
  add_variable(3);
  add({0});
  tree_.update({});
  for (Index v = 1; v < 120; ++v) {
    add_variable(v % 4 == 0 ? 2 : 3);
    add({v - 1, v});
    if (v % 7 == 0) add({v / 3, v});
    if (v % 11 == 0) add({v / 2, v - 5, v});
    const std::vector<Index> last = {v};
    tree_.update(last);
    // Variables stay where they are while they would move by less than a thousandth of a standard deviation (1 at most here).
    ASSERT_LT(error(), 3e-3) << v;
  }
  tree_.set_solution(0, Eigen::Vector3d::Constant(1.0));  // all are looked at again
  tree_.update({});
  EXPECT_LT(error(), 3e-3);
}

TEST_F(FrontTreeTest, TouchesFewVariablesOfAChain) {
  add_variable(3);
  add({0});
  std::size_t most = 0;
  for (Index v = 1; v < 400; ++v) {
    add_variable(3);
    add({v - 1, v});
    const std::vector<Index> last = {v};
    most = std::max(most, tree_.update(last));
  }
  EXPECT_LT(most, 20u);
}

TEST_F(FrontTreeTest, AChangedQuadraticCountsAsItIsNow) {
  for (Index v = 0; v < 60; ++v) {
    add_variable(3);
    if (v == 0) add({0});
    if (v > 0) add({v - 1, v});
  }
  tree_.update({});
  ASSERT_LT(error(), 1e-9);  // all at once: nothing is left where it was
  for (const std::size_t q : {std::size_t{5}, std::size_t{30}, std::size_t{59}}) {
    quadratics_[q] = random_quadratic(quadratics_[q].variables);
    tree_.change_quadratic(static_cast<Index>(q), quadratics_[q].H, quadratics_[q].b);
    EXPECT_LT(tree_.update({}), 61u);
    EXPECT_LT(error(), 3e-3);
  }
}

TEST_F(FrontTreeTest, PartsThatShareNothingStandSideBySideUntilSomethingTiesThem) {
  for (Index v = 0; v < 20; ++v) {
    add_variable(3);
    add({v});
  }
  EXPECT_EQ(tree_.update({}), 20u);
  EXPECT_LT(error(), 1e-9);
  add({3, 15});
  EXPECT_EQ(tree_.update({}), 2u);
  EXPECT_LT(error(), 1e-3);
}

TEST_F(FrontTreeTest, WhatNothingDeterminesStaysWhereItIs) {
  add_variable(2);
  quadratics_.push_back({{0}, Eigen::MatrixXd::Zero(2, 2), Eigen::VectorXd::Zero(2)});
  quadratics_.back().H(0, 0) = 4.0;
  quadratics_.back().b[0] = 8.0;
  tree_.add_quadratic(quadratics_.back());
  tree_.update({});
  EXPECT_NEAR(tree_.solution(0)[0], 2.0, 1e-6);
  EXPECT_EQ(tree_.solution(0)[1], 0.0);
}

}  // namespace
}  // namespace mapjoin
