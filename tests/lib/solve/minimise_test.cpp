// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/solve/minimise.hpp>
#include <tests/support/dense_problem.hpp>
#include <tuple>

namespace mapjoin {
namespace {

using testing::arctangent;
using testing::DenseProblem;
using testing::rosenbrock;
using testing::to_the_end;

/// Powell's badly scaled function, whose valley is a hyperbola; the minimum is at (1.098e-5, 9.106).
Eigen::VectorXd badly_scaled(const Eigen::VectorXd& x) {
  return Eigen::Vector2d(1e4 * x[0] * x[1] - 1.0, std::exp(-x[0]) + std::exp(-x[1]) - 1.0001);
}

class MinimiseTest : public ::testing::TestWithParam<Method> {
 protected:
  /// Expects chi2 to fall with every step, as dogleg and Levenberg-Marquardt promise.
  static void expect_descent(const DenseProblem& problem) {
    for (std::size_t k = 1; k < problem.visited.size(); ++k) EXPECT_LT(problem.visited[k], problem.visited[k - 1]);
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, MinimiseTest,
                         ::testing::Values(Method::kGaussNewton, Method::kDogleg, Method::kLevenbergMarquardt),
                         [](const auto& method) { return to_string(method.param); });

TEST_P(MinimiseTest, FindsTheBottomOfRosenbrocksValley) {
  DenseProblem problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  const MinimiseResult result = minimise(problem, to_the_end(GetParam()));
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_LT((problem.estimate() - Eigen::Vector2d(1.0, 1.0)).norm(), 1e-8);
  EXPECT_NEAR(result.start_chi2, rosenbrock(Eigen::Vector2d(-1.2, 1.0)).squaredNorm(), 1e-12);
  EXPECT_LT(result.chi2, 1e-15);
  if (GetParam() != Method::kGaussNewton) expect_descent(problem);
}

TEST_P(MinimiseTest, FindsTheMinimumWhereScalesDifferByMillions) {
  DenseProblem problem(badly_scaled, Eigen::Vector2d(0.0, 1.0));
  const MinimiseResult result = minimise(problem, to_the_end(GetParam()));
  EXPECT_EQ(result.status, MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[1], 9.10614673986652, 1e-6);
  if (GetParam() != Method::kGaussNewton) expect_descent(problem);
}

TEST_P(MinimiseTest, OnlyGaussNewtonIsLedAstray) {
  DenseProblem problem(arctangent, Eigen::VectorXd::Constant(1, 3.0));
  const MinimiseResult result = minimise(problem, to_the_end(GetParam()));
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
  MinimiseOptions options = to_the_end(GetParam());
  options.max_iterations = 1;
  DenseProblem problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  const MinimiseResult result = minimise(problem, options);
  EXPECT_EQ(result.status, MinimiseStatus::kMaxIterations);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_EQ(result.chi2, rosenbrock(problem.estimate()).squaredNorm());
}

TEST_P(MinimiseTest, RecordsTheCourseOfChi2) {
  MinimiseOptions options = to_the_end(GetParam());
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
  const MinimiseResult result = minimise(problem, to_the_end(GetParam()));
  EXPECT_EQ(result.status, MinimiseStatus::kSingular);
  EXPECT_EQ(result.singular, Variable(1));
  EXPECT_EQ(problem.estimate(), Eigen::Vector2d(1.0, 2.0));
}

TEST_P(MinimiseTest, FindsWhatOnlyDampingDetermines) {
  const auto sum = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::Vector2d(x[0] + x[1] - 1.0, 0.1)); };
  DenseProblem problem(sum, Eigen::Vector2d(3.0, 4.0));
  EXPECT_EQ(minimise(problem, to_the_end(GetParam())).status, MinimiseStatus::kSingular);
}

TEST_P(MinimiseTest, MayDampAVariableThatNothingDeterminesYet) {
  const auto sum = [](const Eigen::VectorXd& x) { return Eigen::VectorXd::Constant(1, x[0] + x[1] - 3.0); };
  MinimiseOptions options = to_the_end(GetParam());
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
  EXPECT_EQ(minimise(problem, to_the_end(GetParam())).status, MinimiseStatus::kNoProgress);
  EXPECT_EQ(problem.estimate()[0], 1.0);
}

TEST_P(MinimiseTest, TakesNoStepToWhereChi2IsNotFinite) {
  const auto logarithm = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(x.array().log()); };
  DenseProblem problem(logarithm, Eigen::VectorXd::Constant(1, 3.0));  // the Gauss-Newton step leads below 0
  const MinimiseResult result = minimise(problem, to_the_end(GetParam()));
  const bool is_plain = GetParam() == Method::kGaussNewton;
  EXPECT_EQ(result.status, is_plain ? MinimiseStatus::kNoProgress : MinimiseStatus::kConverged);
  EXPECT_NEAR(problem.estimate()[0], is_plain ? 3.0 : 1.0, 1e-6);
}

TEST_P(MinimiseTest, StopsWhereAskedTo) {
  std::stop_source stop;
  stop.request_stop();
  DenseProblem problem(rosenbrock, Eigen::Vector2d(-1.2, 1.0));
  const MinimiseResult result = minimise(problem, to_the_end(GetParam()), stop.get_token());
  EXPECT_EQ(result.status, MinimiseStatus::kInterrupted);
  EXPECT_EQ(problem.estimate(), Eigen::Vector2d(-1.2, 1.0));
}

TEST(Minimise, TheDoglegFactorisesOncePerLinearisation) {
  DenseProblem problem(arctangent, Eigen::VectorXd::Constant(1, 30.0));
  minimise(problem, to_the_end(Method::kDogleg));
  EXPECT_EQ(problem.factorisations, static_cast<int>(problem.visited.size()));
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
