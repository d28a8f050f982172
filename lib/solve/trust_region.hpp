// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far a step may go: the dogleg's radius, Levenberg-Marquardt's damping, and their update by what a step achieved.

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <mapjoin/solve/minimise_options.hpp>

namespace mapjoin {

/// The quadratic model of chi2 at the estimate: g, the scale D = diag(H) in which steps are measured, and the Cauchy point.
struct Quadratic {
  Eigen::VectorXd gradient;
  Eigen::VectorXd scale;
  Eigen::VectorXd cauchy;         ///< The minimiser of the model along D⁻¹ g.
  double cauchy_curvature = 0.0;  ///< cᵀHc.

  template <typename Problem>
  static Quadratic of(const Problem& problem) {
    Quadratic model{problem.gradient(), problem.diagonal(), {}, 0.0};
    model.cauchy = (model.scale.array() > 0.0).select(model.gradient.cwiseQuotient(model.scale), 0.0);
    const double curvature = problem.curvature(model.cauchy);
    const double length = curvature > 0.0 ? model.gradient.dot(model.cauchy) / curvature : 0.0;
    model.cauchy *= length;
    model.cauchy_curvature = length * length * curvature;
    return model;
  }
  /// |v| in the scale D.
  double length(const Eigen::VectorXd& v) const { return std::sqrt(v.cwiseAbs2().dot(scale)); }
};

class TrustRegion {
 public:
  explicit TrustRegion(Method method) : method_(method) {}

  /// False where only the radius shrank and the Gauss-Newton step still stands.
  bool needs_factorisation() const { return needs_factorisation_; }
  double damping() const { return method_ == Method::kLevenbergMarquardt ? damping_ : 0.0; }
  /// The solution of (H + damping·D) n = g.
  void set_newton_step(Eigen::VectorXd newton, double damping, const Quadratic& model);

  /// The step to try: within the radius for the dogleg.
  Eigen::VectorXd step(const Quadratic& model);
  /// By how much the model says the step lowers chi2.
  double predicted_decrease() const { return predicted_; }
  bool is_finite() const { return std::isfinite(predicted_) && std::isfinite(step_length_); }
  /// Whether a step that promises little means that the whole Gauss-Newton step does: it is that step, or that one promises
  /// little, too. Else the region has only shrunk.
  bool speaks_for_whole_step(double chi2) const;

  /// Updates radius or damping by what the step achieved.
  void judge(double actual_decrease);
  bool accepted() const { return accepted_; }

 private:
  void judge_radius(double ratio);
  void judge_damping(double ratio);

  Method method_;
  Eigen::VectorXd newton_;
  double newton_length_ = 0.0;
  double newton_decrease_ = 0.0;  // what the model promises for the whole Gauss-Newton step
  double radius_ = std::numeric_limits<double>::infinity();
  double damping_ = 1e-6;
  double damping_growth_ = 2.0;
  double step_length_ = 0.0;
  double predicted_ = 0.0;
  bool needs_factorisation_ = true;
  bool accepted_ = false;
};

}  // namespace mapjoin
