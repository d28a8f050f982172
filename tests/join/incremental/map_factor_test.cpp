// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/incremental/map_factor.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

template <typename D>
class MapFactorTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;

  MapFactorTest() {
    for (int v = 0; v < 4; ++v) {
      JoinedVariable<kDim>& variable = variables_.emplace_back();
      variable.is_pose = v < 2;
      variable.column = Variable(1 + v);
      variable.reference = variable.value = random_.pose<kDim>(2.0, 0.8);
    }
    map_.base = 0;
    map_.poses = {1};
    map_.features = {0, 1};
    map_.pose_estimates = {retract(between(variables_[0].value, variables_[1].value), noise())};
    for (const JoinedIndex v : IndexRange<JoinedIndex>{2, 4}) {
      map_.feature_estimates.push_back(transform_into(variables_[0].value, variables_[v].value.translation) +
                                       random_.vector<kDim>(0.05));
    }
    constexpr int kRows = kDof + 2 * kDim;
    map_.information = 100.0 * random_.information<kRows>();
  }

  PoseVector<kDim> noise() { return random_.vector<kDof>(0.05); }

  double chi2_with(const MapFactor<kDim>& factor, const Eigen::VectorXd& steps) const {
    JoinedVariables<kDim> moved = variables_;
    Eigen::Index entry = 0;
    for (auto& variable : moved) {
      PoseVector<kDim> step = variable.step;
      step.head(variable.dof()) = steps.segment(entry, variable.dof());
      entry += variable.dof();
      variable.move_to(step);
    }
    return factor.chi2(moved);
  }

  Eigen::VectorXd steps() const {
    Eigen::VectorXd all(2 * kDof + 2 * kDim);
    Eigen::Index entry = 0;
    for (const auto& variable : variables_) {
      all.segment(entry, variable.dof()) = variable.step.head(variable.dof());
      entry += variable.dof();
    }
    return all;
  }

  void move_all(double metres) {
    for (auto& variable : variables_) variable.move_to(random_.vector<kDof>(metres));
  }

  testing::Random random_{11};
  JoinedVariables<kDim> variables_;
  LocalMap<kDim> map_;
};
TYPED_TEST_SUITE(MapFactorTest, testing::Dimensions);

TYPED_TEST(MapFactorTest, TheQuadraticHasChi2AndItsGradientHoweverFarTheVariablesHaveGone) {
  for (const double metres : {0.0, 0.1, 1.0}) {
    this->move_all(metres);
    MapFactor<TestFixture::kDim> factor(this->map_, {0, 1, 2, 3});
    const Quadratic system = factor.linearise(this->variables_);
    const Eigen::VectorXd at = this->steps();
    Eigen::VectorXd x(at.size() + 1);
    x << at, 1.0;
    const Eigen::VectorXd Hx = system.H.template selfadjointView<Eigen::Lower>() * x;
    const double chi2 = this->chi2_with(factor, at);
    EXPECT_NEAR(x.dot(Hx), chi2, 1e-9 * chi2);
    const Eigen::VectorXd gradient = 2.0 * Hx.head(at.size());
    for (Eigen::Index i = 0; i < at.size(); ++i) {
      constexpr double kStep = 1e-6;
      Eigen::VectorXd ahead = at, behind = at;
      ahead[i] += kStep;
      behind[i] -= kStep;
      const double expected = (this->chi2_with(factor, ahead) - this->chi2_with(factor, behind)) / (2.0 * kStep);
      EXPECT_NEAR(gradient[i], expected, 1e-5 * gradient.cwiseAbs().maxCoeff() + 1e-4) << metres << ' ' << i;
    }
  }
}

TYPED_TEST(MapFactorTest, SaysHowFarTheLinearisationErrs) {
  MapFactor<TestFixture::kDim> factor(this->map_, {0, 1, 2, 3});
  factor.linearise(this->variables_);
  EXPECT_LT(factor.fit(this->variables_).error, 1e-18);
  EXPECT_EQ(factor.fit(this->variables_).chi2, factor.chi2(this->variables_));
  // A tenth of the step makes a ten-thousandth of the squared error of the residual, and a hundredth of the error by the turn
  // of the base.
  const PoseVector<TestFixture::kDim> step = this->random_.template vector<TestFixture::kDof>(0.1);
  this->variables_[0].move_to(step);
  const double error = factor.fit(this->variables_).error;
  this->variables_[0].move_to(0.1 * step);
  const double smaller = factor.fit(this->variables_).error;
  EXPECT_GT(error, 1e-3);
  EXPECT_GT(smaller, 0.5e-4 * error);
  EXPECT_LT(smaller, 2e-2 * error);
}

TYPED_TEST(MapFactorTest, AMotionOfFeaturesAloneIsLinear) {
  MapFactor<TestFixture::kDim> factor(this->map_, {0, 1, 2, 3});
  factor.linearise(this->variables_);
  this->variables_[2].move_to(PoseVector<TestFixture::kDim>::Constant(3.0));
  const auto fit = factor.fit(this->variables_);
  EXPECT_GT(fit.chi2, 1.0);
  EXPECT_LT(fit.error, 1e-18 * fit.chi2);
}

TYPED_TEST(MapFactorTest, WhatIsHeldHasNoColumns) {
  this->variables_[0].column = kConstant;
  MapFactor<TestFixture::kDim> factor(this->map_, {0, 1, 2, 3});
  const Quadratic system = factor.linearise(this->variables_);
  EXPECT_EQ(system.variables, (std::vector<Variable>{2, 3, 4, FrontTree::kOne}));
  EXPECT_EQ(system.H.rows(), TestFixture::kDof + 2 * TestFixture::kDim + 1);
}

}  // namespace
}  // namespace mapjoin
