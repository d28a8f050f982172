// SPDX-License-Identifier: BSD-3-Clause
// Ends of minimise() where chi2 is not what Gauss-Newton takes it for: whether it goes on, and whether it says that it
// converged.
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/solve/minimise.hpp>
#include <tests/support/dense_problem.hpp>

namespace mapjoin {
namespace {

using testing::arctangent;
using testing::DenseProblem;
using testing::rosenbrock;
using testing::to_the_end;

/// A problem in which rounding adds more to chi2 than the last step gains.
struct RoundedProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  double try_step(const Eigen::VectorXd& v) { return DenseProblem::try_step(v) * (1.0 + 1e-14); }
};

TEST(MinimiseEnd, TheLastStepIsTakenThoughChi2CannotShowItsGain) {
  const auto h = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(x[0] - 1.0, 1e3)); };
  RoundedProblem problem(h, Eigen::VectorXd::Constant(1, 1.0 + 1e-5));
  const MinimiseResult result = minimise(problem, to_the_end(Method::kDogleg));
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[0], 1.0, 1e-9);
}

/// A problem that has the H of Gauss-Newton only.
struct FlatProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  void add_curvature() {}
};

/// A function for which chi2 curves 1 + 2c times as much at 0 as Gauss-Newton takes it to.
DenseProblem::Function valley(double c) {
  return [c](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(x[0], 1.0 + c * x[0] * x[0])); };
}

TEST(MinimiseEnd, DoesNotCreepAlongAValleyWhoseCurvatureGaussNewtonOverrates) {
  DenseProblem problem(valley(-0.475), Eigen::VectorXd::Constant(1, 0.5));
  const MinimiseResult result = minimise(problem, to_the_end(Method::kDogleg));
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[0], 0.0, 1e-6);
  FlatProblem plain(valley(-0.475), Eigen::VectorXd::Constant(1, 0.5));
  EXPECT_LT(10 * result.iterations, minimise(plain, to_the_end(Method::kDogleg)).iterations);
}

TEST(MinimiseEnd, GoesOnByGaussNewtonWhereChi2IsNotConvex) {
  DenseProblem problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  EXPECT_EQ(minimise(problem, to_the_end(Method::kDogleg)).status, MinimiseStatus::kConverged);
  DenseProblem hill(valley(-2.0), Eigen::VectorXd::Constant(1, 0.01));  // 0 is a maximum between two minima
  const MinimiseResult result = minimise(hill, to_the_end(Method::kDogleg));
  EXPECT_NEAR(std::abs(hill.estimate()[0]), std::sqrt(3.0 / 8.0), 1e-6);
  EXPECT_EQ(result.factorisations, hill.factorisations);
}

/// A problem whose chi2 is never below 1, its value at the start: no step gains anything.
struct KinkedProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  double try_step(const Eigen::VectorXd& v) { return std::max(DenseProblem::try_step(v), 1.0); }
};

TEST(MinimiseEnd, HasNotConvergedWhereOnlyTheRegionShrankToNothing) {
  const auto h = [](const Eigen::VectorXd& x) { return x; };
  KinkedProblem problem(h, Eigen::VectorXd::Constant(1, 1.0));
  EXPECT_EQ(minimise(problem, to_the_end(Method::kDogleg)).status, MinimiseStatus::kNoProgress);
}

/// A problem in which every step raises chi2.
struct RaisedProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  double try_step(const Eigen::VectorXd& v) { return DenseProblem::try_step(v) + 1.0; }
};

TEST(MinimiseEnd, StaysWhereEveryStepRaisesChi2) {
  for (const auto method : {Method::kDogleg, Method::kLevenbergMarquardt}) {
    const auto h = [](const Eigen::VectorXd& x) { return x; };
    RaisedProblem problem(h, Eigen::VectorXd::Constant(1, 1.0));
    EXPECT_EQ(minimise(problem, to_the_end(method)).status, MinimiseStatus::kNoProgress);
    EXPECT_EQ(problem.estimate()[0], 1.0);
  }
}

TEST(MinimiseEnd, HasConvergedAtItsLimitOfIterationsWhereNothingIsLeftToGain) {
  for (const double start : {1e-4, 1e-2}) {
    DenseProblem problem(valley(-0.475), Eigen::VectorXd::Constant(1, start));
    MinimiseOptions options = to_the_end(Method::kGaussNewton);
    options.step_metres = options.step_radians = 0.0;
    options.max_iterations = 3;
    EXPECT_EQ(minimise(problem, options).status, start == 1e-4 ? MinimiseStatus::kConverged : MinimiseStatus::kMaxIterations);
  }
}

TEST(MinimiseEnd, LevenbergMarquardtEndsWithAnUndampedStep) {
  const auto h = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(x[0] - 1.0, 10.0)); };
  DenseProblem problem(h, Eigen::VectorXd::Constant(1, 1.1));
  MinimiseOptions options = to_the_end(Method::kLevenbergMarquardt);
  options.relative_chi2 = 1e-3;
  EXPECT_EQ(minimise(problem, options).status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[0], 1.0, 1e-9);
}

/// A problem in which the steps of damped systems lead uphill.
struct DampedUphill : DenseProblem {
  using DenseProblem::DenseProblem;
  std::optional<Variable> factorise(double damping) {
    is_damped = damping > 0.0;
    return DenseProblem::factorise(damping);
  }
  Eigen::VectorXd solve() const { return (is_damped ? -1.0 : 1.0) * DenseProblem::solve(); }
  bool is_damped = false;
};

TEST(MinimiseEnd, DoglegGoesOnWhereLevenbergMarquardtMakesNoProgress) {
  DampedUphill problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  const MinimiseOptions options = to_the_end(Method::kLevenbergMarquardt);
  const MinimiseResult result = minimise(problem, options);
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_LE(result.iterations, options.max_iterations);
  EXPECT_EQ(result.factorisations, problem.factorisations);
  EXPECT_NEAR(problem.estimate()[0], 1.0, 1e-6);
}

/// A problem whose system is singular unless it is damped by a thousandth.
struct StubbornProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  std::optional<Variable> factorise(double damping) {
    return damping < 0.999e-3 ? std::optional(Variable(0)) : DenseProblem::factorise(damping);
  }
};

TEST(MinimiseEnd, DampsASingularSystemByAsMuchAsItTakes) {
  StubbornProblem problem(arctangent, Eigen::VectorXd::Constant(1, 0.5));
  MinimiseOptions options = to_the_end(Method::kDogleg);
  options.damp_singular = true;
  EXPECT_EQ(minimise(problem, options).status, MinimiseStatus::kConverged);
}

}  // namespace
}  // namespace mapjoin
