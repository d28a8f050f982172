// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/solve/trust_region.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The β in [0, 1] at which c + β (n - c) has length `radius`, from |c|², cᵀDn and |n|²; |c| ≤ radius ≤ |n|.
double dogleg_fraction(double cc, double cn, double nn, double radius) {
  const double a = nn - 2.0 * cn + cc;
  const double b = cn - cc;
  const double e = cc - radius * radius;
  const double root = std::sqrt(std::max(0.0, b * b - a * e));
  // The positive root of aβ² + 2bβ + e, in the form without cancellation.
  const double beta = b > 0.0 ? -e / (b + root) : (root - b) / a;
  return std::clamp(beta, 0.0, 1.0);
}

/// The largest decrease of chi2, as a share of it, with which a step has moved the estimate little: the last factor may then
/// serve once more.
constexpr double kLittle = 0.01;
/// The largest promise of a repeated step, as a share of that of the step before.
constexpr double kRepeatedShare = 0.05;
/// A step that gains less than this share of what was promised fell short: chi2 is not nearly quadratic that far.
constexpr double kShort = 0.4;
/// A step that gains more than this share of what was promised shows, too, that chi2 curves otherwise than the model.
constexpr double kMuchMore = 1.5;

}  // namespace

bool TrustRegion::may_repeat(double chi2) const {
  return method_ == Method::kDogleg && accepted_ && took_newton_step_ && predicted_ <= kLittle * chi2;
}

void TrustRegion::propose_repeated(ModelStep newton) {
  if (!(newton.decrease <= kRepeatedShare * predicted_)) return;
  set_newton_step(std::move(newton));
  is_repeated_ = true;
}

Eigen::VectorXd TrustRegion::step() {
  took_newton_step_ = !is_truncated() && !newton_.is_damped;
  if (!is_truncated()) {
    predicted_ = newton_.decrease;
    step_length_ = newton_.length;
    return newton_.v;
  }
  step_length_ = radius_;
  const double gc = cauchy_.decrease;  // gᵀc = cᵀHc
  if (cauchy_.length >= radius_) {
    const double share = radius_ / cauchy_.length;
    predicted_ = (2.0 * share - share * share) * gc;
    return share * cauchy_.v;
  }
  const double beta =
      dogleg_fraction(cauchy_.length * cauchy_.length, cauchy_newton_, newton_.length * newton_.length, radius_);
  const double gn = newton_.decrease;
  const double gs = (1.0 - beta) * gc + beta * gn;
  // H n = g, so cᵀHn = gᵀc and nᵀHn = gᵀn.
  const double sHs = (1.0 - beta) * (1.0 - beta) * gc + 2.0 * beta * (1.0 - beta) * gc + beta * beta * gn;
  predicted_ = 2.0 * gs - sHs;
  return (1.0 - beta) * cauchy_.v + beta * newton_.v;
}

void TrustRegion::judge(double chi2_before, double chi2) {
  const double ratio = (chi2_before - chi2) / predicted_;
  fell_short_ = !(ratio > kShort);
  creeps_ = (fell_short_ || ratio > kMuchMore) && chi2_before - chi2 <= kLittle * chi2;
  switch (method_) {
    case Method::kGaussNewton:
      accepted_ = true;
      break;
    case Method::kDogleg:
      judge_radius(ratio);
      break;
    case Method::kLevenbergMarquardt:
      judge_damping(ratio);
      break;
  }
  if (accepted_) has_cauchy_point_ = false;
  if (accepted_ || is_repeated_) needs_factorisation_ = true;
}

void TrustRegion::judge_radius(double ratio) {
  accepted_ = ratio > 1e-4;  // false for NaN too
  if (!(ratio > 0.25)) {
    radius_ = (accepted_ ? 0.5 : 0.25) * step_length_;
  } else if (ratio > 0.75) {
    radius_ = std::max(radius_, 3.0 * step_length_);
  }
}

/// Nielsen's update: smooth for good steps, ever faster growth for bad ones.
void TrustRegion::judge_damping(double ratio) {
  accepted_ = ratio > 1e-4;
  if (accepted_) {
    damping_ *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * ratio - 1.0, 3.0));
    damping_growth_ = 2.0;
  } else {
    damping_ *= damping_growth_;
    damping_growth_ *= 2.0;
  }
}

}  // namespace mapjoin
