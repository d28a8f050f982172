// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <mapjoin/join/incremental/quadratic_sum.hpp>
#include <mapjoin/model/lists.hpp>
#include <set>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// A sum of quadratics, each over all variables of some groups.
class QuadraticSumTest : public ::testing::Test {
 protected:
  void add_group(int variables, int rank) {
    groups_.emplace_back();
    for (int k = 0; k < variables; ++k) {
      const Variable v(sum_.variables.size());
      sum_.variables.push_back({v, v.value % 2 == 0 ? 3 : 2, rank});
      groups_.back().push_back(v);
      offsets_.push_back(offsets_.back() + sum_.variables.back().dof);
    }
  }

  /// Adds a positive definite quadratic over the variables of these groups, those of each group in descending order.
  void add_quadratic(const std::vector<std::size_t>& groups) {
    Quadratic& added = quadratics_.emplace_back();
    for (const std::size_t g : groups) added.variables.insert(added.variables.end(), groups_[g].rbegin(), groups_[g].rend());
    const auto size = static_cast<Eigen::Index>(rows_of(added.variables).size());
    Eigen::MatrixXd A(size, size);
    for (auto& entry : A.reshaped()) entry = random_.uniform(-1.0, 1.0);
    added.H = A * A.transpose() + Eigen::MatrixXd::Identity(size, size);
  }

  std::vector<Eigen::Index> rows_of(const std::vector<Variable>& variables) const {
    std::vector<Eigen::Index> rows;
    for (const Variable v : variables) {
      for (Eigen::Index row = offsets_[v]; row < offsets_[v + 1]; ++row) rows.push_back(row);
    }
    return rows;
  }

  std::vector<SumNode> eliminated() {
    sum_.quadratics.clear();
    for (const Quadratic& quadratic : quadratics_) sum_.quadratics.push_back(&quadratic);
    return eliminate(sum_);
  }

  /// The sum of L Lᵀ of all fronts, each at its rows of the sum of quadratics.
  Eigen::MatrixXd product(const std::vector<SumNode>& nodes) const {
    Eigen::MatrixXd product = Eigen::MatrixXd::Zero(offsets_.back(), offsets_.back());
    for (const SumNode& node : nodes) {
      if (node.quadratic) continue;
      auto rows = rows_of(node.front.frontals);
      const std::size_t width = rows.size();
      const auto below = rows_of(node.front.separator);
      rows.insert(rows.end(), below.begin(), below.end());
      Eigen::MatrixXd L = node.front.L;
      L.topRows(static_cast<Eigen::Index>(width)).triangularView<Eigen::StrictlyUpper>().setZero();
      product(rows, rows) += L * L.transpose();
    }
    return product;
  }

  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(offsets_.back(), offsets_.back());
    for (const Quadratic& quadratic : quadratics_) {
      const auto rows = rows_of(quadratic.variables);
      dense(rows, rows) += quadratic.H;
    }
    return dense;
  }

  testing::Random random_{11};
  QuadraticSum sum_;
  std::vector<Quadratic> quadratics_;
  std::vector<std::vector<Variable>> groups_;
  Table<Variable, Eigen::Index> offsets_{0};
};

TEST_F(QuadraticSumTest, FrontsAreTheFactorOfTheSum) {
  for (int g = 0; g < 12; ++g) add_group(1 + g % 5, g == 4 ? 1 : 0);
  add_group(1, 2);
  for (std::size_t g = 0; g < 12; ++g) add_quadratic({12, g, (g + 1) % 12});
  add_quadratic({3, 9, 12});
  const auto nodes = eliminated();
  EXPECT_LE((product(nodes) - dense()).norm(), 1e-12 * dense().norm());
}

TEST_F(QuadraticSumTest, FrontsOfManyBlocksAreTheFactorOfTheSum) {
  for (int g = 0; g < 300; ++g) add_group(1 + g % 2, g == 7 ? 1 : 0);
  add_group(1, 2);
  for (std::size_t g = 0; g + 1 < 300; ++g) add_quadratic({300, g + 1, g});
  const auto nodes = eliminated();
  EXPECT_GT(nodes.size(), 400u);
  EXPECT_LE((product(nodes) - dense()).norm(), 1e-12 * dense().norm());
}

TEST_F(QuadraticSumTest, AFrontSendsTheSchurComplementOfAllBelow) {
  for (int g = 0; g < 40; ++g) add_group(3, 0);
  add_group(1, 1);
  for (std::size_t g = 0; g + 1 < 40; ++g) add_quadratic({g + 1, g, 40});
  const auto nodes = eliminated();
  std::vector<Eigen::MatrixXd> sums(nodes.size() + 1, Eigen::MatrixXd::Zero(offsets_.back(), offsets_.back()));
  std::vector<std::vector<Variable>> gone(nodes.size() + 1);
  int sent = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const SumNode& node = nodes[n];
    if (node.quadratic) {
      const Quadratic& quadratic = quadratics_[*node.quadratic];
      const auto rows = rows_of(quadratic.variables);
      sums[n](rows, rows) += quadratic.H;
    }
    append(gone[n], node.front.frontals);
    sums[node.parent] += sums[n];
    append(gone[node.parent], gone[n]);
    EXPECT_EQ(node.update.variables, node.front.separator);
    if (node.front.separator.empty()) continue;
    const auto f = rows_of(gone[n]);
    const auto s = rows_of(node.front.separator);
    const Eigen::MatrixXd D_ff = sums[n](f, f);
    const Eigen::MatrixXd D_fs = sums[n](f, s);
    const Eigen::MatrixXd expected = sums[n](s, s) - D_fs.transpose() * D_ff.llt().solve(D_fs);
    const Eigen::MatrixXd found = node.update.H.selfadjointView<Eigen::Lower>();
    EXPECT_LE((found - expected).norm(), 1e-12 * expected.norm());
    ++sent;
  }
  EXPECT_GT(sent, 1);
}

TEST_F(QuadraticSumTest, WhatIsInNoQuadraticStandsByItself) {
  add_group(3, 0);
  add_group(1, 1);
  add_group(1, 2);
  add_quadratic({1, 2});
  std::size_t alone = 0;
  const auto nodes = eliminated();
  for (const SumNode& node : nodes) {
    if (node.quadratic || !node.front.is_singular) continue;
    EXPECT_EQ(node.front.frontals.size(), 1u);
    EXPECT_TRUE(node.front.separator.empty());
    ++alone;
  }
  EXPECT_EQ(alone, 3u);
}

TEST_F(QuadraticSumTest, NodesAreATreeThatHasEachVariableAndEachQuadraticOnce) {
  for (int g = 0; g < 40; ++g) add_group(3, 0);
  add_group(1, 1);
  for (std::size_t g = 0; g + 1 < 40; ++g) add_quadratic({g + 1, g, 40});
  const auto nodes = eliminated();
  std::map<Variable, int> frontals;
  std::set<std::size_t> quadratics;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    EXPECT_GT(nodes[n].parent, n);
    for (const Variable v : nodes[n].front.frontals) ++frontals[v];
    if (!nodes[n].quadratic) continue;
    EXPECT_TRUE(quadratics.insert(*nodes[n].quadratic).second);
    const auto& taken_by = nodes[nodes[n].parent].front.frontals;
    EXPECT_TRUE(std::ranges::any_of(quadratics_[*nodes[n].quadratic].variables,
                                    [&](Variable v) { return std::ranges::find(taken_by, v) != taken_by.end(); }));
  }
  EXPECT_EQ(frontals.size(), sum_.variables.size());
  EXPECT_TRUE(std::ranges::all_of(frontals, [](const auto& found) { return found.second == 1; }));
  EXPECT_EQ(quadratics.size(), quadratics_.size());
  EXPECT_EQ(nodes.back().front.frontals.back(), groups_.back().front()) << "the highest rank comes last";
}

TEST_F(QuadraticSumTest, VariablesOfTheSameQuadraticsAreInOneFront) {
  for (int g = 0; g < 60; ++g) add_group(8, 0);
  add_group(1, 1);
  for (std::size_t g = 0; g + 2 < 60; ++g) add_quadratic({g, g + 2, g + 1, 60});
  for (const SumNode& node : eliminated()) {
    if (node.quadratic) continue;
    const std::set<Variable> frontals(node.front.frontals.begin(), node.front.frontals.end());
    for (const auto& group : groups_) {
      const auto here = std::ranges::count_if(group, [&](Variable v) { return frontals.contains(v); });
      EXPECT_TRUE(here == 0 || here == static_cast<std::ptrdiff_t>(group.size()));
    }
  }
}

TEST_F(QuadraticSumTest, AFrontSaysThatItEliminatesWhatNothingDetermines) {
  for (int g = 0; g < 5; ++g) add_group(1, 0);
  add_group(1, 1);
  for (std::size_t g = 0; g < 5; ++g) add_quadratic({g, 5});
  quadratics_[2].H.row(1).setZero();
  quadratics_[2].H.col(1).setZero();
  for (const SumNode& node : eliminated()) {
    EXPECT_EQ(node.front.is_singular, std::ranges::count(node.front.frontals, groups_[2].front()) == 1);
  }
}

}  // namespace
}  // namespace mapjoin
