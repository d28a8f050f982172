// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/join/incremental/deferred_front.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

constexpr int kDof = 2;
constexpr int kInTree = 30;
constexpr int kNew = 3;
constexpr Eigen::Index kOwn = kDof * kNew;  // entries of the new variables, behind those of the tree
constexpr Eigen::Index kOthers = kDof * kInTree;

/// A tree of a chain of variables at its optimum, three new variables that are not in it, and the same as dense matrices.
class DeferredFrontTest : public ::testing::Test {
 protected:
  struct Dense {
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kOthers + kOwn, kOthers + kOwn);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(kOthers + kOwn);
    double c = 0.0;

    double at(const Eigen::VectorXd& x) const { return x.dot(H * x) - 2.0 * b.dot(x) + c; }
    Dense& operator+=(const Dense& other) {
      H += other.H;
      b += other.b;
      c += other.c;
      return *this;
    }
  };

  DeferredFrontTest() {
    for (int k = 0; k < kInTree + kNew; ++k) tree_.add_variable(kDof);
    for (int k = 1; k <= kInTree; ++k) {
      const auto [quadratic, dense] =
          random_quadratic(k == 1 ? std::vector<Variable>{1} : std::vector{Variable(k - 1), Variable(k)});
      tree_.add_quadratic(quadratic);
      in_tree_ += dense;
    }
    tree_.update({});
  }

  /// (x - m)ᵀ AAᵀ (x - m) + 0.1 over the entries of some variables, with random A and m.
  std::pair<Quadratic, Dense> random_quadratic(std::vector<Variable> variables) {
    std::vector<Eigen::Index> entries;
    for (const Variable v : variables) {
      for (int i = 0; i < kDof; ++i) entries.push_back(kDof * (v.value - 1) + i);
    }
    const auto size = static_cast<Eigen::Index>(entries.size());
    Eigen::MatrixXd A(size, size);
    for (auto& entry : A.reshaped()) entry = random_.uniform(-1.0, 1.0);
    Eigen::VectorXd mean(size);
    for (double& entry : mean) entry = random_.uniform(-1.0, 1.0);
    const Eigen::MatrixXd W = A * A.transpose();
    Dense dense;
    dense.H(entries, entries) = W;
    dense.b(entries) = W * mean;
    dense.c = mean.dot(W * mean) + 0.1;
    variables.push_back(FrontTree::kOne);
    Eigen::MatrixXd H(size + 1, size + 1);
    H << W, -W * mean, -(W * mean).transpose(), dense.c;
    return {{std::move(variables), H}, dense};
  }

  void defer(std::vector<Variable> variables) {
    auto [quadratic, dense] = random_quadratic(std::move(variables));
    deferred_.add(std::move(quadratic));
    dense_.push_back(dense);
  }
  void defer_some() {
    defer({30, 31});
    defer({33, 31, 30});
    defer({32, 29, 33});
    defer({5, 30});  // a closure
  }

  Dense deferred() const {
    Dense sum;
    for (const Dense& dense : dense_) sum += dense;
    return sum;
  }
  /// The solution of the tree, with the new variables where the deferred quadratics cost least.
  Eigen::VectorXd expected() const {
    Eigen::VectorXd x(kOthers + kOwn);
    for (int k = 1; k <= kInTree; ++k) x.segment<kDof>(kDof * (k - 1)) = tree_.solution(Variable(k));
    const Dense sum = deferred();
    x.tail(kOwn) = sum.H.bottomRightCorner<kOwn, kOwn>().llt().solve(sum.b.tail(kOwn) -
                                                                     sum.H.bottomLeftCorner<kOwn, kOthers>() * x.head(kOthers));
    return x;
  }

  testing::Random random_{3};
  FrontTree tree_;
  Dense in_tree_;
  DeferredFront deferred_;
  std::vector<Dense> dense_;
};

TEST_F(DeferredFrontTest, SolvesForWhatTheTreeDoesNotHave) {
  defer_some();
  deferred_.solve(tree_);
  EXPECT_EQ(deferred_.front()->frontals, (std::vector<Variable>{31, 32, 33}));
  EXPECT_LE((deferred_.solution() - expected().tail(kOwn)).norm(), 1e-10 * expected().norm());
}

TEST_F(DeferredFrontTest, CountsWhatHasBeenChangedAndRemoved) {
  defer_some();
  deferred_.solve(tree_);
  auto [quadratic, dense] = random_quadratic({30, 31});
  deferred_.change(0, std::move(quadratic));
  dense_[0] = dense;
  deferred_.remove(3);
  dense_.erase(dense_.begin() + 3);
  deferred_.solve(tree_);
  EXPECT_LE((deferred_.solution() - expected().tail(kOwn)).norm(), 1e-10 * expected().norm());
  EXPECT_EQ(deferred_.take().size(), 3u);
  EXPECT_EQ(deferred_.size(), 0u);
  EXPECT_FALSE(deferred_.front());
}

TEST_F(DeferredFrontTest, TheGainIsABoundOnWhatAllCouldFallByTogether) {
  defer_some();
  deferred_.solve(tree_);
  const double gain = deferred_.gain(tree_).value();
  const Eigen::VectorXd x = expected();
  Dense all = in_tree_;
  all += deferred();
  const double fall = all.at(x) - all.at(all.H.llt().solve(all.b));
  EXPECT_GE(gain, fall);
  // The gain is half the harmonic mean of what the deferred quadratics cost and of what the tree would gain if their pull on it
  // did not change.
  const Eigen::VectorXd pull = (deferred().b - deferred().H * x).head(kOthers);
  const double tree_alone = pull.dot(in_tree_.H.topLeftCorner<kOthers, kOthers>().llt().solve(pull));
  const double cost = deferred().at(x);
  EXPECT_NEAR(1.0 / gain, 1.0 / tree_alone + 1.0 / cost, 1e-9 / gain);
  EXPECT_GT(fall, 0.01 * gain);  // the bound is within a factor of a hundred
}

TEST_F(DeferredFrontTest, AClosureAloneHasAGain) {
  defer({5, 30});
  deferred_.solve(tree_);
  EXPECT_TRUE(deferred_.front()->frontals.empty());
  Dense all = in_tree_;
  all += deferred();
  all.H.bottomRightCorner<kOwn, kOwn>().setIdentity();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kOthers + kOwn);
  for (int k = 1; k <= kInTree; ++k) x.segment<kDof>(kDof * (k - 1)) = tree_.solution(Variable(k));
  const double fall = all.at(x) - all.at(all.H.llt().solve(all.b));
  const double gain = deferred_.gain(tree_).value();
  EXPECT_GE(gain, fall);
  EXPECT_LE(gain, deferred().at(x));
}

TEST_F(DeferredFrontTest, NothingIsGainedWhereOnlyNewVariablesHangOn) {
  const auto [quadratic, dense] = random_quadratic({31});
  deferred_.add(quadratic);
  deferred_.solve(tree_);
  EXPECT_EQ(deferred_.gain(tree_), 0.0);
}

TEST_F(DeferredFrontTest, WhereAVariableIsNotDeterminedNothingIsKnownOfTheGain) {
  auto [quadratic, dense] = random_quadratic({31, 32});
  quadratic.H.row(3).setZero();
  quadratic.H.col(3).setZero();
  deferred_.add(quadratic);
  deferred_.solve(tree_);
  EXPECT_FALSE(deferred_.gain(tree_));
  EXPECT_FALSE(tree_.factor().covariance(std::vector<Variable>{31}, deferred_.front().get()));
}

/// The covariance of x = A⁻¹(b - B s), with s of the tree and its covariance P, is A⁻¹ + G P Gᵀ, where G = A⁻¹B
/// (Schmidt-Kalman).
TEST_F(DeferredFrontTest, CovariancesAreThoseOfTheEstimateThatHoldsTheTree) {
  defer_some();
  deferred_.solve(tree_);
  const Dense sum = deferred();
  const Eigen::MatrixXd A_inverse = sum.H.bottomRightCorner<kOwn, kOwn>().llt().solve(Eigen::MatrixXd::Identity(kOwn, kOwn));
  Eigen::MatrixXd of_others = Eigen::MatrixXd::Identity(kOthers + kOwn, kOthers);  // all variables by those of the tree
  of_others.bottomRows(kOwn) = -A_inverse * sum.H.bottomLeftCorner<kOwn, kOthers>();
  const Eigen::MatrixXd P =
      in_tree_.H.topLeftCorner<kOthers, kOthers>().llt().solve(Eigen::MatrixXd::Identity(kOthers, kOthers));
  Eigen::MatrixXd expected = of_others * P * of_others.transpose();
  expected.bottomRightCorner<kOwn, kOwn>() += A_inverse;
  for (const std::vector<Variable>& some : {std::vector<Variable>{31}, {33, 2}, {30, 32}, {7}}) {
    std::vector<Eigen::Index> entries;
    for (const Variable v : some) {
      for (int i = 0; i < kDof; ++i) entries.push_back(kDof * (v.value - 1) + i);
    }
    const Eigen::MatrixXd found = tree_.factor().covariance(some, deferred_.front().get()).value();
    EXPECT_LE((found - expected(entries, entries)).norm(), 1e-10 * found.norm()) << some[0].value;
  }
  EXPECT_FALSE(tree_.factor().covariance(std::vector<Variable>{31}));  // the tree alone knows nothing of it
}

}  // namespace
}  // namespace mapjoin
