// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

/// A tree of fronts, and the sum of its quadratics as a dense matrix.
class FrontTreeTest : public ::testing::Test {
 protected:
  void add_variable(int dof) {
    tree_.add_variable(dof);
    offsets_.push_back(offsets_.back() + dof);
  }
  int dof(Variable v) const { return static_cast<int>(offsets_[v + 1] - offsets_[v]); }

  /// A random quadratic δᵀHδ - 2bᵀδ + c, H of full rank, with a minimum that is not negative.
  Quadratic random_quadratic(std::vector<Variable> variables) {
    variables.push_back(FrontTree::kOne);
    Eigen::Index size = 0;
    for (const Variable v : variables) size += dof(v);
    Eigen::MatrixXd A(size, size);
    for (auto& entry : A.reshaped()) entry = random_.uniform(-1.0, 1.0);
    return {std::move(variables), A * A.transpose() + Eigen::MatrixXd::Identity(size, size)};
  }

  void add(std::vector<Variable> variables) {
    quadratics_.push_back(random_quadratic(std::move(variables)));
    indices_.push_back(tree_.add_quadratic(quadratics_.back()));
  }

  Eigen::MatrixXd sum() const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(offsets_.back(), offsets_.back());
    for (const Quadratic& q : quadratics_) {
      std::vector<Eigen::Index> entries;
      for (const Variable v : q.variables) {
        for (int i = 0; i < dof(v); ++i) entries.push_back(offsets_[v] + i);
      }
      sum(entries, entries) += q.H;
    }
    return sum;
  }

  /// The largest difference between the solution of the tree and that of the dense system, relative to the largest entry of the
  /// latter.
  double error() const {
    const Eigen::MatrixXd sum = this->sum();
    const Eigen::Index size = sum.rows() - 1;
    const Eigen::VectorXd expected = sum.bottomRightCorner(size, size).llt().solve(-sum.col(0).tail(size));
    double worst = 0.0;
    for (Variable v = 1; v.position() + 1 < offsets_.size(); ++v) {
      const Eigen::VectorXd found = tree_.solution(v);
      worst = std::max(worst, (found - expected.segment(offsets_[v] - 1, found.size())).cwiseAbs().maxCoeff());
    }
    return worst / expected.cwiseAbs().maxCoeff();
  }

  testing::Random random_{7};
  FrontTree tree_;
  Table<Variable, Eigen::Index> offsets_{0, 1};  // FrontTree::kOne is the first variable
  std::vector<Quadratic> quadratics_;
  std::vector<FrontTree::QuadraticIndex> indices_;
};

TEST_F(FrontTreeTest, SolvesAGrowingChainWithClosuresAfterEveryUpdate) {
  add_variable(3);
  add({1});
  tree_.update({});
  for (int k = 2; k < 121; ++k) {
    const Variable v(k);
    add_variable(k % 4 == 0 ? 2 : 3);
    add({v - 1, v});
    if (k % 7 == 0) add({Variable(k / 3), v});
    if (k % 11 == 0) add({Variable(k / 2), v - 5, v});
    const std::vector<Variable> last = {v};
    tree_.update(last);
    // Variables stay where they are while they would move by less than a thousandth of a standard deviation (1 at most here).
    ASSERT_LT(error(), 3e-3) << k;
  }
  tree_.set_solution(1, Eigen::Vector3d::Constant(1.0));  // the whole tree is looked at again
  tree_.update({});
  EXPECT_LT(error(), 3e-3);
}

TEST_F(FrontTreeTest, CovariancesAreBlocksOfTheInverse) {
  for (int k = 1; k < 61; ++k) {
    const Variable v(k);
    add_variable(k % 4 == 0 ? 2 : 3);
    if (k == 1) add({v});
    if (k > 1) add({v - 1, v});
    if (k > 1 && k % 7 == 0) add({Variable(k / 3), v});
    if (k % 20 == 0) tree_.update({});  // so that the tree has fronts of several eliminations
  }
  const Eigen::Index size = offsets_.back() - 1;
  const Eigen::MatrixXd inverse = sum().bottomRightCorner(size, size).llt().solve(Eigen::MatrixXd::Identity(size, size));
  for (Variable v = 1; v < 61; ++v) {
    const Eigen::MatrixXd expected = inverse.block(offsets_[v] - 1, offsets_[v] - 1, dof(v), dof(v));
    const Eigen::MatrixXd covariance = tree_.factor().covariance({&v, 1}).value();
    ASSERT_EQ(covariance.rows(), dof(v));
    EXPECT_LE((covariance - expected).norm(), 1e-10 * expected.norm()) << v.value;
  }
  for (const std::vector<Variable>& some : {std::vector<Variable>{3, 60}, {60, 3}, {31, 32}, {1, 20, 45}}) {
    std::vector<Eigen::Index> entries;
    for (const Variable v : some) {
      for (int i = 0; i < dof(v); ++i) entries.push_back(offsets_[v] - 1 + i);
    }
    const Eigen::MatrixXd expected = inverse(entries, entries);
    EXPECT_LE((tree_.factor().covariance(some).value() - expected).norm(), 1e-10 * expected.norm()) << some[0].value;
  }
}

TEST_F(FrontTreeTest, TouchesFewVariablesOfAChain) {
  add_variable(3);
  add({1});
  std::size_t eliminated = 0;
  std::size_t moved = 0;
  for (Variable v = 2; v < 401; ++v) {
    add_variable(3);
    add({v - 1, v});
    const std::vector<Variable> last = {v};
    eliminated = std::max(eliminated, tree_.update(last));
    moved = std::max(moved, tree_.moved().size());
  }
  EXPECT_LT(eliminated, 20u);
  EXPECT_LT(moved, 30u);
}

TEST_F(FrontTreeTest, AChangedQuadraticCountsAsItIsNow) {
  for (Variable v = 1; v < 61; ++v) {
    add_variable(3);
    if (v == 1) add({v});
    if (v > 1) add({v - 1, v});
  }
  tree_.update({});
  ASSERT_LT(error(), 1e-9);  // all are eliminated at once, and none is left where it was
  for (const std::size_t q : {std::size_t{5}, std::size_t{30}, std::size_t{59}}) {
    quadratics_[q].H = 2.0 * random_quadratic({quadratics_[q].variables.begin(), quadratics_[q].variables.end() - 1}).H;
    tree_.change_quadratic(indices_[q], quadratics_[q].H);
    EXPECT_LT(tree_.update({}), 61u);
    EXPECT_LT(error(), 3e-3);
  }
}

TEST_F(FrontTreeTest, ARemovedQuadraticLeavesNoTrace) {
  for (Variable v = 1; v < 61; ++v) {
    add_variable(3);
    if (v == 1) add({v});
    if (v > 1) add({v - 1, v});
  }
  const std::size_t in_chain = quadratics_.size();
  add({2, 30, 58});
  add({25, 40});
  tree_.update({});
  add({7, 50});  // not in the tree yet
  for (const std::size_t q : {in_chain + 2, in_chain, in_chain + 1}) {
    tree_.remove_quadratic(indices_[q]);
    quadratics_[q].H.setZero();
    EXPECT_EQ(tree_.update({}) > 0, q < in_chain + 2);
    EXPECT_LT(error(), 3e-3) << q;
  }
  const Variable end = 60;
  const Eigen::Index size = offsets_.back() - 1;
  const Eigen::MatrixXd inverse = sum().bottomRightCorner(size, size).llt().solve(Eigen::MatrixXd::Identity(size, size));
  const Eigen::Matrix3d expected = inverse.bottomRightCorner<3, 3>();
  EXPECT_LE((tree_.factor().covariance({&end, 1}).value() - expected).norm(), 1e-10 * expected.norm());
}

/// The quadratic 1e12 (x - 100)², whose minimum of 0 is the difference of two numbers of 1e16.
TEST_F(FrontTreeTest, AVariableFarFromItsReferenceIsDetermined) {
  add_variable(1);
  Quadratic far{{1, FrontTree::kOne}, Eigen::MatrixXd(2, 2)};
  far.H << 1e12, -1e14, -1e14, 1e16;
  tree_.add_quadratic(far);
  tree_.update({});
  EXPECT_NEAR(tree_.solution(1)[0], 100.0, 1e-9);
  const auto covariance = tree_.factor().covariance(std::vector<Variable>{1});
  ASSERT_TRUE(covariance);
  EXPECT_NEAR(covariance->value(), 1e-12, 1e-24);
}

TEST_F(FrontTreeTest, PartsThatShareNothingStandSideBySideUntilSomethingTiesThem) {
  for (Variable v = 1; v < 21; ++v) {
    add_variable(3);
    add({v});
  }
  EXPECT_EQ(tree_.update({}), 20u);
  EXPECT_LT(error(), 1e-9);
  add({4, 16});
  EXPECT_LT(tree_.update({}), 8u);  // variables 4 and 16, and those at the root
  EXPECT_LT(error(), 1e-3);
}

TEST_F(FrontTreeTest, EliminatesAgainFrontsBelowThatSendMuchForWhatTheyEliminate) {
  constexpr std::size_t kHub = 20;
  constexpr std::size_t kLeaves = 30;
  std::vector<Variable> hub;
  for (Variable v = 1; hub.size() < kHub; ++v) {
    add_variable(3);
    hub.push_back(v);
  }
  add(hub);
  for (std::size_t k = 0; k < kLeaves; ++k) {
    add_variable(2);
    std::vector<Variable> leaf = hub;
    leaf.emplace_back(kHub + 1 + k);
    add(leaf);
  }
  for (std::size_t k = 0; k < 100; ++k) {  // a chain from the hub, whose fronts send few variables
    add_variable(3);
    const Variable v(kHub + kLeaves + 1 + k);
    add({k == 0 ? Variable(1) : v - 1, v});
  }
  tree_.update({});
  quadratics_.front() = random_quadratic(hub);
  tree_.change_quadratic(indices_.front(), quadratics_.front().H);
  const std::size_t eliminated = tree_.update({});
  EXPECT_GE(eliminated, kHub + kLeaves);
  EXPECT_LE(eliminated, kHub + kLeaves + 20);
  EXPECT_LT(error(), 3e-3);
}

TEST_F(FrontTreeTest, WhatNothingDeterminesStaysWhereItIs) {
  add_variable(2);
  Quadratic first{{1, FrontTree::kOne}, Eigen::MatrixXd::Zero(3, 3)};
  first.H(0, 0) = 4.0;
  first.H(2, 0) = -8.0;
  first.H(2, 2) = 20.0;
  tree_.add_quadratic(first);
  tree_.update({});
  EXPECT_NEAR(tree_.solution(1)[0], 2.0, 1e-6);
  EXPECT_EQ(tree_.solution(1)[1], 0.0);
  EXPECT_FALSE(tree_.factor().covariance(std::vector<Variable>{1}));
}

}  // namespace
}  // namespace mapjoin
