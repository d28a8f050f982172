// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <functional>
#include <mapjoin/solve/minimise.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tuple>

namespace mapjoin {
namespace {

/// A LeastSquaresProblem over a dense vector; r(x) = -residual to the measured zero. Records chi2 at every estimate.
class DenseProblem {
 public:
  using Function = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
  DenseProblem(Function h, Eigen::VectorXd start) : h_(std::move(h)), x_(std::move(start)) {}

  double linearise() {
    const Eigen::VectorXd r = -h_(x_);
    const Eigen::MatrixXd J =
        testing::numerical_jacobian([&](const Eigen::VectorXd& step) { return h_(x_ + step); }, x_.size());
    H_ = J.transpose() * J;
    g_ = J.transpose() * r;
    visited.push_back(r.squaredNorm());
    return r.squaredNorm();
  }
  void add_curvature() {
    const auto gradient = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
      const auto h = [&](const Eigen::VectorXd& more) { return h_(x_ + step + more); };
      return testing::numerical_jacobian(h, x_.size(), 1e-5).transpose() * h_(x_ + step);
    };
    H_ = testing::numerical_jacobian(gradient, x_.size(), 1e-5);
  }
  Eigen::VectorXd gradient() const { return g_; }
  DiagonalMetric metric() const { return DiagonalMetric(H_.diagonal()); }
  double curvature(const Eigen::VectorXd& v) const { return v.dot(H_ * v); }
  std::optional<Variable> factorise(double damping) {
    ++factorisations;
    Eigen::MatrixXd damped = H_;
    damped.diagonal() *= 1.0 + damping;
    llt_.compute(damped);
    const Eigen::VectorXd pivots = llt_.matrixLLT().diagonal().cwiseAbs2();
    for (Eigen::Index i = 0; i < pivots.size(); ++i) {
      if (!(pivots[i] > 1e-14 * damped(i, i))) return Variable(i);
    }
    if (llt_.info() != Eigen::Success) return Variable(1);  // of two variables, the second one's pivot
    return std::nullopt;
  }
  Eigen::VectorXd solve() const { return llt_.solve(g_); }
  StepSize step_size(const Eigen::VectorXd& v) const { return {v.norm(), 0.0}; }
  double try_step(const Eigen::VectorXd& v) {
    candidate_ = x_ + v;
    return h_(candidate_).squaredNorm();
  }
  void accept() { x_ = candidate_; }

  const Eigen::VectorXd& estimate() const { return x_; }
  std::vector<double> visited;
  int factorisations = 0;

 private:
  Function h_;
  Eigen::VectorXd x_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd candidate_;
  Eigen::VectorXd g_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

Eigen::VectorXd rosenbrock(const Eigen::VectorXd& x) {
  return Eigen::Vector2d(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]);
}

/// Powell's badly scaled function: the valley is a hyperbola, the minimum at (1.098e-5, 9.106).
Eigen::VectorXd badly_scaled(const Eigen::VectorXd& x) {
  return Eigen::Vector2d(1e4 * x[0] * x[1] - 1.0, std::exp(-x[0]) + std::exp(-x[1]) - 1.0001);
}

/// Gauss-Newton steps away from its minimum at 0.
Eigen::VectorXd arctangent(const Eigen::VectorXd& x) {
  return Eigen::VectorXd::Constant(1, std::atan(x[0]));
}

MinimiseOptions with(Method method) {
  MinimiseOptions options;
  options.method = method;
  options.relative_chi2 = 1e-14;
  return options;
}

class MinimiseTest : public ::testing::TestWithParam<Method> {
 protected:
  /// Dogleg and Levenberg-Marquardt may not climb.
  static void expect_descent(const DenseProblem& problem) {
    for (std::size_t k = 1; k < problem.visited.size(); ++k) EXPECT_LT(problem.visited[k], problem.visited[k - 1]);
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, MinimiseTest,
                         ::testing::Values(Method::kGaussNewton, Method::kDogleg, Method::kLevenbergMarquardt),
                         [](const auto& method) { return to_string(method.param); });

TEST_P(MinimiseTest, FindsTheBottomOfRosenbrocksValley) {
  DenseProblem problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  const MinimiseResult result = minimise(problem, with(GetParam()));
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_LT((problem.estimate() - Eigen::Vector2d(1.0, 1.0)).norm(), 1e-8);
  EXPECT_NEAR(result.start_chi2, rosenbrock(Eigen::Vector2d(-1.2, 1.0)).squaredNorm(), 1e-12);
  EXPECT_LT(result.chi2, 1e-15);
  if (GetParam() != Method::kGaussNewton) expect_descent(problem);
}

TEST_P(MinimiseTest, FindsTheMinimumWhereScalesDifferByMillions) {
  DenseProblem problem(badly_scaled, Eigen::Vector2d(0.0, 1.0));
  const MinimiseResult result = minimise(problem, with(GetParam()));
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[1], 9.10614673986652, 1e-6);
  if (GetParam() != Method::kGaussNewton) expect_descent(problem);
}

TEST_P(MinimiseTest, OnlyGaussNewtonIsLedAstray) {
  DenseProblem problem(arctangent, Eigen::VectorXd::Constant(1, 3.0));
  const MinimiseResult result = minimise(problem, with(GetParam()));
  if (GetParam() == Method::kGaussNewton) {
    EXPECT_NE(result.status, MinimiseStatus::kConverged);
    EXPECT_TRUE(problem.estimate().allFinite());
  } else {
    EXPECT_EQ(result.status, MinimiseStatus::kConverged);
    EXPECT_NEAR(problem.estimate()[0], 0.0, 1e-7);
    expect_descent(problem);
  }
}

TEST_P(MinimiseTest, StopsAtTheGivenNumberOfIterations) {
  MinimiseOptions options = with(GetParam());
  options.max_iterations = 1;
  DenseProblem problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  const MinimiseResult result = minimise(problem, options);
  EXPECT_EQ(result.status, MinimiseStatus::kMaxIterations);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_EQ(result.chi2, rosenbrock(problem.estimate()).squaredNorm());
}

TEST_P(MinimiseTest, RecordsTheCourseOfChi2) {
  MinimiseOptions options = with(GetParam());
  DenseProblem whole(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  const MinimiseResult result = minimise(whole, options);
  ASSERT_EQ(result.course.size(), static_cast<std::size_t>(result.iterations));
  EXPECT_EQ(result.course.back(), result.chi2);
  options.max_iterations = 2;
  DenseProblem part(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  minimise(part, options);
  EXPECT_EQ(result.course[1], rosenbrock(part.estimate()).squaredNorm());
}

TEST_P(MinimiseTest, NamesASingularVariableAndLeavesTheEstimate) {
  const auto blind = [](const Eigen::VectorXd& x) { return Eigen::VectorXd::Constant(1, x[0] - 3.0); };
  DenseProblem problem(blind, Eigen::Vector2d(1.0, 2.0));
  const MinimiseResult result = minimise(problem, with(GetParam()));
  EXPECT_EQ(result.status, MinimiseStatus::kSingular);
  EXPECT_EQ(result.singular, Variable(1));
  EXPECT_EQ(problem.estimate(), Eigen::Vector2d(1.0, 2.0));
}

TEST_P(MinimiseTest, FindsWhatOnlyDampingDetermines) {
  const auto sum = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(x[0] + x[1] - 1.0, 0.1)); };
  DenseProblem problem(sum, Eigen::Vector2d(3.0, 4.0));
  EXPECT_EQ(minimise(problem, with(GetParam())).status, MinimiseStatus::kSingular);
}

TEST_P(MinimiseTest, MayDampAVariableThatNothingDeterminesYet) {
  const auto sum = [](const Eigen::VectorXd& x) { return Eigen::VectorXd::Constant(1, x[0] + x[1] - 3.0); };
  MinimiseOptions options = with(GetParam());
  options.damp_singular = true;
  DenseProblem problem(sum, Eigen::Vector2d(0.0, 0.0));
  const MinimiseResult result = minimise(problem, options);
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate().sum(), 3.0, 1e-6);
  EXPECT_NEAR(problem.estimate()[0], problem.estimate()[1], 1e-6);
}

TEST_P(MinimiseTest, TakesNoStepWhereChi2IsNotFinite) {
  const auto broken = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(x / 0.0); };
  DenseProblem problem(broken, Eigen::VectorXd::Ones(1));
  EXPECT_EQ(minimise(problem, with(GetParam())).status, MinimiseStatus::kNoProgress);
  EXPECT_EQ(problem.estimate()[0], 1.0);
}

TEST_P(MinimiseTest, TakesNoStepToWhereChi2IsNotFinite) {
  const auto logarithm = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(x.array().log()); };
  DenseProblem problem(logarithm, Eigen::VectorXd::Constant(1, 3.0));  // from where the Gauss-Newton step leads below 0
  const MinimiseResult result = minimise(problem, with(GetParam()));
  const bool is_plain = GetParam() == Method::kGaussNewton;
  EXPECT_EQ(result.status, is_plain ? MinimiseStatus::kNoProgress : MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[0], is_plain ? 3.0 : 1.0, 1e-6);
}

TEST_P(MinimiseTest, StopsWhereAskedTo) {
  std::stop_source stop;
  stop.request_stop();
  DenseProblem problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  const MinimiseResult result = minimise(problem, with(GetParam()), stop.get_token());
  EXPECT_EQ(result.status, MinimiseStatus::kInterrupted);
  EXPECT_EQ(problem.estimate(), Eigen::Vector2d(-1.2, 1.0));
}

TEST(Minimise, TheDoglegFactorisesOncePerLinearisation) {
  DenseProblem problem(arctangent, Eigen::VectorXd::Constant(1, 30.0));
  minimise(problem, with(Method::kDogleg));
  EXPECT_EQ(problem.factorisations, static_cast<int>(problem.visited.size()));
}

/// What rounding adds to chi2 is more than what the last step gains.
struct RoundedProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  double try_step(const Eigen::VectorXd& v) { return DenseProblem::try_step(v) * (1.0 + 1e-14); }
};

TEST(Minimise, TheLastStepIsTakenThoughChi2CannotShowItsGain) {
  const auto h = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(x[0] - 1.0, 1e3)); };
  RoundedProblem problem(h, Eigen::VectorXd::Constant(1, 1.0 + 1e-5));
  const MinimiseResult result = minimise(problem, with(Method::kDogleg));
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[0], 1.0, 1e-9);
}

/// One that has Gauss-Newton's H only.
struct FlatProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  void add_curvature() {}
};

/// At the minimum, 0, chi2 curves 1 + 2c times what Gauss-Newton takes it to.
DenseProblem::Function valley(double c) {
  return [c](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(x[0], 1.0 + c * x[0] * x[0])); };
}

TEST(Minimise, DoesNotCreepAlongAValleyWhoseCurvatureGaussNewtonOverrates) {
  DenseProblem problem(valley(-0.475), Eigen::VectorXd::Constant(1, 0.5));
  const MinimiseResult result = minimise(problem, with(Method::kDogleg));
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[0], 0.0, 1e-6);
  FlatProblem plain(valley(-0.475), Eigen::VectorXd::Constant(1, 0.5));
  EXPECT_LT(10 * result.iterations, minimise(plain, with(Method::kDogleg)).iterations);
}

TEST(Minimise, GoesOnByGaussNewtonWhereChi2IsNotConvex) {
  DenseProblem problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  EXPECT_EQ(minimise(problem, with(Method::kDogleg)).status, MinimiseStatus::kConverged);
  DenseProblem hill(valley(-2.0), Eigen::VectorXd::Constant(1, 0.01));  // 0 is a maximum between two minima
  const MinimiseResult result = minimise(hill, with(Method::kDogleg));
  EXPECT_NEAR(std::abs(hill.estimate()[0]), std::sqrt(3.0 / 8.0), 1e-6);
  EXPECT_EQ(result.factorisations, hill.factorisations);
}

/// Of which no step but a tiny one gains what it promises: |x| with a kink where the start is.
struct KinkedProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  double try_step(const Eigen::VectorXd& v) { return std::max(DenseProblem::try_step(v), 1.0); }
};

TEST(Minimise, HasNotConvergedWhereOnlyTheRegionShrankToNothing) {
  const auto h = [](const Eigen::VectorXd& x) { return x; };
  KinkedProblem problem(h, Eigen::VectorXd::Constant(1, 1.0));
  EXPECT_EQ(minimise(problem, with(Method::kDogleg)).status, MinimiseStatus::kNoProgress);
}

/// Of which every step raises chi2.
struct RaisedProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  double try_step(const Eigen::VectorXd& v) { return DenseProblem::try_step(v) + 1.0; }
};

TEST(Minimise, StaysWhereEveryStepRaisesChi2) {
  for (const auto method : {Method::kDogleg, Method::kLevenbergMarquardt}) {
    const auto h = [](const Eigen::VectorXd& x) { return x; };
    RaisedProblem problem(h, Eigen::VectorXd::Constant(1, 1.0));
    EXPECT_EQ(minimise(problem, with(method)).status, MinimiseStatus::kNoProgress);
    EXPECT_EQ(problem.estimate()[0], 1.0);
  }
}

TEST(Minimise, HasConvergedAtItsLimitOfIterationsWhereNothingIsLeftToGain) {
  for (const double start : {1e-4, 1e-2}) {
    DenseProblem problem(valley(-0.475), Eigen::VectorXd::Constant(1, start));
    MinimiseOptions options = with(Method::kGaussNewton);
    options.step_metres = options.step_radians = 0.0;
    options.max_iterations = 3;
    EXPECT_EQ(minimise(problem, options).status, start == 1e-4 ? MinimiseStatus::kConverged : MinimiseStatus::kMaxIterations);
  }
}

TEST(Minimise, LevenbergMarquardtEndsWithAnUndampedStep) {
  const auto h = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(x[0] - 1.0, 10.0)); };
  DenseProblem problem(h, Eigen::VectorXd::Constant(1, 1.1));
  MinimiseOptions options = with(Method::kLevenbergMarquardt);
  options.relative_chi2 = 1e-3;
  EXPECT_EQ(minimise(problem, options).status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[0], 1.0, 1e-9);
}

/// Singular unless it is damped by a thousandth.
struct StubbornProblem : DenseProblem {
  using DenseProblem::DenseProblem;
  std::optional<Variable> factorise(double damping) {
    return damping < 0.999e-3 ? std::optional(Variable(0)) : DenseProblem::factorise(damping);
  }
};

TEST(Minimise, DampsASingularSystemByAsMuchAsItTakes) {
  StubbornProblem problem(arctangent, Eigen::VectorXd::Constant(1, 0.5));
  MinimiseOptions options = with(Method::kDogleg);
  options.damp_singular = true;
  EXPECT_EQ(minimise(problem, options).status, MinimiseStatus::kConverged);
}

TEST(Minimise, OptionsNameEveryViolation) {
  EXPECT_TRUE(MinimiseOptions{}.validate().empty());
  MinimiseOptions options;
  options.max_iterations = 0;
  options.relative_chi2 = -1.0;
  options.step_metres = std::nan("");
  options.step_radians = -1.0;
  EXPECT_EQ(options.validate().size(), 4u);
}

}  // namespace
}  // namespace mapjoin
