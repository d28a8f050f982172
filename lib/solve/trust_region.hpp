// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How long a step is, and how far it may go: the metric of the steps, the dogleg's radius, Levenberg-Marquardt's damping, and
// their update by what a step achieved.

#include <Eigen/Core>
#include <cmath>
#include <concepts>
#include <limits>
#include <mapjoin/solve/minimise_options.hpp>
#include <utility>

namespace mapjoin {

/// The metric D of the trust region, in which Levenberg-Marquardt damps, too.
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
  const Eigen::VectorXd& diagonal() const { return diagonal_; }

 private:
  Eigen::VectorXd diagonal_;
};

/// A step and what the quadratic model says of it.
struct ModelStep {
  Eigen::VectorXd v;
  double decrease = 0.0;  ///< By how much the model lowers chi2.
  double length = 0.0;    ///< |v| in the metric of the steps.
  bool is_damped = false;
};

class TrustRegion {
 public:
  explicit TrustRegion(Method method) : method_(method) {}

  /// False where only the radius shrank and the Gauss-Newton step still stands.
  bool needs_factorisation() const { return needs_factorisation_; }
  double damping() const { return method_ == Method::kLevenbergMarquardt ? damping_ : 0.0; }
  /// The solution of (H + damping·D) n = g.
  void set_newton_step(ModelStep newton) {
    newton_ = std::move(newton);
    has_cauchy_point_ = false;
    needs_factorisation_ = method_ == Method::kLevenbergMarquardt;
    is_repeated_ = false;
  }
  /// Where the Gauss-Newton step is too long for the dogleg.
  bool needs_cauchy_point() const { return is_truncated() && !has_cauchy_point_; }
  template <StepMetric M>
  void set_cauchy_point(ModelStep cauchy, const M& metric) {
    cauchy_newton_ = metric.inner(cauchy.v, newton_.v);
    cauchy_ = std::move(cauchy);
    has_cauchy_point_ = true;
  }

  /// Whether the last factor may serve once more: the dogleg took the whole Gauss-Newton step that it gave, and chi2 is now
  /// not much less than before.
  bool may_repeat(double chi2) const;
  /// The step by the last factor at the new estimate. It is tried where it promises so much less than the one before that it
  /// converges without another factorisation.
  void propose_repeated(ModelStep newton);

  /// The step to try: within the radius for the dogleg.
  Eigen::VectorXd step();
  /// By how much the model says the step lowers chi2.
  double predicted_decrease() const { return predicted_; }
  bool is_finite() const { return std::isfinite(predicted_) && std::isfinite(step_length_); }
  /// By how much the model says the whole Gauss-Newton step lowers chi2, however far the region lets a step go; of
  /// Levenberg-Marquardt, the damped one.
  double promise() const { return newton_.decrease; }
  /// Whether the Gauss-Newton step is too long for the dogleg.
  bool is_truncated() const { return method_ == Method::kDogleg && newton_.length > radius_; }

  /// Updates radius or damping by what the step achieved.
  void judge(double chi2_before, double chi2);
  bool accepted() const { return accepted_; }
  /// Whether the last step judged gained less than 0.4 of what the model said.
  bool fell_short() const { return fell_short_; }
  /// Whether it lowered chi2 by a hundredth at most, and by far less or more than the model said: H is then far from that of
  /// chi2.
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
