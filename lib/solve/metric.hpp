// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How long a step is: the metric D of the trust region, in which Levenberg-Marquardt damps, too.

#include <Eigen/Core>
#include <cmath>
#include <concepts>
#include <utility>

namespace mapjoin {

template <typename M>
concept StepMetric = requires(const M& metric, const Eigen::VectorXd& v) {
  { metric.inner(v, v) } -> std::convertible_to<double>;          // uᵀ D v
  { metric.descent(v) } -> std::convertible_to<Eigen::VectorXd>;  // D⁻¹ g, the direction of steepest descent for the gradient g
};

template <StepMetric M>
double length(const M& metric, const Eigen::VectorXd& v) {
  return std::sqrt(metric.inner(v, v));
}

/// For plain Gauss-Newton, which takes every step as it is.
struct Unmeasured {
  double inner(const Eigen::VectorXd&, const Eigen::VectorXd&) const { return 0.0; }
  Eigen::VectorXd descent(Eigen::VectorXd gradient) const { return gradient; }
};

/// D = diag(H): every entry in units of its own certainty.
class DiagonalMetric {
 public:
  explicit DiagonalMetric(Eigen::VectorXd diagonal) : diagonal_(std::move(diagonal)) {}

  double inner(const Eigen::VectorXd& u, const Eigen::VectorXd& v) const { return u.cwiseProduct(diagonal_).dot(v); }
  /// Entries that nothing determines stay where they are.
  Eigen::VectorXd descent(const Eigen::VectorXd& gradient) const {
    return (diagonal_.array() > 0.0).select(gradient.cwiseQuotient(diagonal_), 0.0);
  }

 private:
  Eigen::VectorXd diagonal_;
};

}  // namespace mapjoin
