// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A check of the H of a least-squares problem against central differences of its chi2.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <tests/support/random.hpp>

namespace mapjoin::testing {

/// Expects that H with its curvature is half of the second derivatives of chi2 along random directions, and without it is not.
template <typename Problem>
void expect_full_newton(Problem& problem) {
  constexpr double kStep = 1e-4;
  Random random;
  const double chi2 = problem.linearise();
  const Eigen::Index size = problem.gradient().size();
  double missed = 0.0;
  for (int k = 0; k < 10; ++k) {
    const Eigen::VectorXd v = Eigen::VectorXd::NullaryExpr(size, [&] { return random.uniform(-1.0, 1.0); });
    const double expected = (problem.try_step(kStep * v) - 2.0 * chi2 + problem.try_step(-kStep * v)) / (2.0 * kStep * kStep);
    problem.linearise();
    const double gauss_newton = problem.curvature(v);
    problem.add_curvature();
    EXPECT_NEAR(problem.curvature(v), expected, 1e-5 * expected);
    missed = std::max(missed, std::abs(gauss_newton - expected) / expected);
  }
  EXPECT_GT(missed, 1e-3);
}

}  // namespace mapjoin::testing
