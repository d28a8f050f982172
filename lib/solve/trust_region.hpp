// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Step control: the metric of the steps, the dogleg's radius, Levenberg-Marquardt's damping, and their update by what a step
// achieved.

#include <Eigen/Core>
#include <cmath>
#include <concepts>
#include <limits>
#include <mapjoin/solve/minimise_options.hpp>
#include <utility>

namespace mapjoin {

/// The metric D of the trust region and of Levenberg-Marquardt's damping.
template <typename M>
concept StepMetric = requires(const M& metric, const Eigen::VectorXd& v) {
  { metric.inner(v, v) } -> std::convertible_to<double>;          // uᵀ D v
  { metric.descent(v) } -> std::convertible_to<Eigen::VectorXd>;  // D⁻¹ g, the direction of steepest descent for the gradient g
};

template <StepMetric M>
double length(const M& metric, const Eigen::VectorXd& v) {
  return std::sqrt(metric.inner(v, v));
}

/// The zero metric, for plain Gauss-Newton, which takes every step as it is.
struct Unmeasured {
  double inner(const Eigen::VectorXd&, const Eigen::VectorXd&) const { return 0.0; }
  Eigen::VectorXd descent(Eigen::VectorXd gradient) const { return gradient; }
};

/// D = diag(H): every entry in units of its own certainty.
class DiagonalMetric {
 public:
  explicit DiagonalMetric(Eigen::VectorXd diagonal) : diagonal_(std::move(diagonal)) {}

  double inner(const Eigen::VectorXd& u, const Eigen::VectorXd& v) const { return u.cwiseProduct(diagonal_).dot(v); }
  /// D⁻¹ g; entries that nothing determines stay where they are.
  Eigen::VectorXd descent(const Eigen::VectorXd& gradient) const {
    return (diagonal_.array() > 0.0).select(gradient.cwiseQuotient(diagonal_), 0.0);
  }
  const Eigen::VectorXd& diagonal() const { return diagonal_; }

 private:
  Eigen::VectorXd diagonal_;
};

/// A step and its prediction by the quadratic model.
struct ModelStep {
  Eigen::VectorXd v;
  double decrease = 0.0;  ///< Decrease of chi2 by the model.
  double length = 0.0;    ///< |v| in the metric of the steps.
  bool is_damped = false;
};

class TrustRegion {
 public:
  explicit TrustRegion(Method method) : method_(method) {}

  /// False if only the radius shrank and the Gauss-Newton step is still valid.
  bool needs_factorisation() const { return needs_factorisation_; }
  double damping() const { return method_ == Method::kLevenbergMarquardt ? damping_ : 0.0; }
  /// Takes the solution of (H + damping·D) n = g.
  void set_newton_step(ModelStep newton) {
    newton_ = std::move(newton);
    has_cauchy_point_ = false;
    needs_factorisation_ = method_ == Method::kLevenbergMarquardt;
    is_repeated_ = false;
  }
  /// True if the Gauss-Newton step is too long for the dogleg and the Cauchy point is not known yet.
  bool needs_cauchy_point() const { return is_truncated() && !has_cauchy_point_; }
  template <StepMetric M>
  void set_cauchy_point(ModelStep cauchy, const M& metric) {
    cauchy_newton_ = metric.inner(cauchy.v, newton_.v);
    cauchy_ = std::move(cauchy);
    has_cauchy_point_ = true;
  }

  /// True if the last factor may serve once more: the dogleg took the whole Gauss-Newton step that it gave, which promised to
  /// lower chi2 by at most a hundredth.
  bool may_repeat(double chi2) const;
  /// Proposes the step by the last factor at the new estimate. It is tried if it promises so much less than the one before that
  /// it converges without another factorisation.
  void propose_repeated(ModelStep newton);

  /// The step to try: within the radius for the dogleg.
  Eigen::VectorXd step();
  /// The decrease of chi2 that the model predicts for step().
  double predicted_decrease() const { return predicted_; }
  bool is_finite() const { return std::isfinite(predicted_) && std::isfinite(step_length_); }
  /// The decrease of chi2 that the model predicts for the whole Gauss-Newton step, whatever the radius; for
  /// Levenberg-Marquardt, the damped one.
  double promise() const { return newton_.decrease; }
  /// True if the Gauss-Newton step is too long for the dogleg.
  bool is_truncated() const { return method_ == Method::kDogleg && newton_.length > radius_; }

  /// Updates radius or damping by what the step achieved.
  void judge(double chi2_before, double chi2);
  bool accepted() const { return accepted_; }
  /// True if the last step judged gained less than 0.4 of the predicted decrease.
  bool fell_short() const { return fell_short_; }
  /// True if the last step judged lowered chi2 by a hundredth at most, and by far less or more than predicted: H is then far
  /// from that of chi2.
  bool creeps() const { return creeps_; }

 private:
  void judge_radius(double ratio);
  void judge_damping(double ratio);

  Method method_;
  ModelStep cauchy_;
  ModelStep newton_;
  double cauchy_newton_ = 0.0;  // cᵀDn
  double radius_ = std::numeric_limits<double>::infinity();
  double damping_ = 1e-6;
  double damping_growth_ = 2.0;
  double step_length_ = 0.0;
  double predicted_ = 0.0;
  bool needs_factorisation_ = true;
  bool has_cauchy_point_ = false;
  bool took_newton_step_ = false;
  bool is_repeated_ = false;
  bool accepted_ = false;
  bool fell_short_ = false;
  bool creeps_ = false;
};

}  // namespace mapjoin
