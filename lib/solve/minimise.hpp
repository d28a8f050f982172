// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The one nonlinear loop: Gauss-Newton, dogleg or Levenberg-Marquardt over any problem that can linearise, solve and step.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <mapjoin/solve/minimise_options.hpp>
#include <mapjoin/solve/trust_region.hpp>
#include <optional>
#include <stop_token>
#include <utility>

namespace mapjoin {

/// A problem with the quadratic model chi2(x ⊕ δ) ≈ chi2 - 2 gᵀδ + δᵀHδ.
template <typename P>
concept LeastSquaresProblem = requires(P p, const Eigen::VectorXd& v, double damping) {
  { p.linearise() } -> std::convertible_to<double>;  // makes H and g at the estimate; returns chi2 there
  {p.add_curvature()};  // makes H that of full Newton, which need not be positive definite, until linearise(); g and D stay
  { p.gradient() } -> std::convertible_to<Eigen::VectorXd>;           // g
  { p.metric() } -> StepMetric;                                       // D, at the estimate
  { p.curvature(v) } -> std::convertible_to<double>;                  // vᵀHv
  { p.factorise(damping) } -> std::same_as<std::optional<Variable>>;  // factor of H + damping·D; a singular variable or nullopt
  { p.solve() } -> std::convertible_to<Eigen::VectorXd>;  // (H + damping·D)⁻¹ g by the last factor, for the present g
  { p.step_size(v) } -> std::same_as<StepSize>;
  { p.try_step(v) } -> std::convertible_to<double>;  // chi2 of the estimate moved by v, kept as the candidate
  {p.accept()};                                      // the candidate becomes the estimate
};

namespace detail {

/// gᵀv. A problem whose vectors are spread over several processes has a slope() of its own.
template <LeastSquaresProblem P>
double slope(P& problem, const Eigen::VectorXd& v) {
  if constexpr (requires { problem.slope(v); }) {
    return problem.slope(v);
  } else {
    return problem.gradient().dot(v);
  }
}

/// The rounding error of chi2, as a share of it.
constexpr double kRounding = 1e-12;

/// The minimiser of the model along the direction of steepest descent; it has gᵀc = cᵀHc.
template <LeastSquaresProblem P, StepMetric M>
ModelStep cauchy_point(P& problem, const M& metric) {
  ModelStep point{metric.descent(problem.gradient())};
  const double curvature = problem.curvature(point.v);
  const double share = curvature > 0.0 ? slope(problem, point.v) / curvature : 0.0;
  point.v *= share;
  point.decrease = share * share * curvature;
  point.length = length(metric, point.v);
  return point;
}

/// The step n of (H + damping·D) n = g, by the last factor.
template <LeastSquaresProblem P, StepMetric M>
ModelStep newton_step(P& problem, double damping, const M& metric) {
  ModelStep step{problem.solve()};
  step.is_damped = damping > 0.0;
  step.length = length(metric, step.v);
  step.decrease = slope(problem, step.v) + damping * step.length * step.length;
  return step;
}

/// Factorises with `damping` or, if `damp_singular`, with the least larger one that makes the system regular, which it writes
/// to `damping`. Returns the first singular variable met if none does. Counts in `factorisations`.
template <LeastSquaresProblem P>
std::optional<Variable> factorise_damped(P& problem, double& damping, bool damp_singular, int& factorisations) {
  const auto singular = problem.factorise(damping);
  ++factorisations;
  if (!singular || !damp_singular) return singular;
  for (double more = std::max(1e-8, 10.0 * damping); more <= 1.0; more *= 10.0) {
    ++factorisations;
    if (problem.factorise(more)) continue;
    damping = more;
    return std::nullopt;
  }
  return singular;
}

/// Makes H that of full Newton and factorises it; if it is not positive definite, makes it Gauss-Newton's again and returns
/// false.
template <LeastSquaresProblem P>
bool factorise_curved(P& problem, int& factorisations) {
  problem.add_curvature();
  ++factorisations;
  if (!problem.factorise(0.0)) return true;
  problem.linearise();
  return false;
}

/// True if a step moves and turns next to nothing. A problem whose positions have digits to lose says what their rounding()
/// hides.
template <LeastSquaresProblem P>
bool is_tiny(P& problem, const Eigen::VectorXd& step, const MinimiseOptions& options) {
  double metres = options.step_metres;
  if constexpr (requires { problem.rounding(); }) metres = std::max(metres, problem.rounding());
  const StepSize size = problem.step_size(step);
  return size.metres <= metres && size.radians <= options.step_radians;
}

/// The steps of minimise(). Their metric, metric_of(), is asked for once an estimate, before H is made full Newton's.
template <LeastSquaresProblem P, typename MetricOf>
class Steps {
 public:
  Steps(MetricOf metric_of, P& problem, const MinimiseOptions& options, const std::stop_token& stop)
      : metric_of_(std::move(metric_of)), problem_(problem), options_(options), stop_(stop), region_(options.method) {}

  MinimiseResult all() {
    result_.chi2 = result_.start_chi2 = problem_.linearise();
    while (true) {
      if (!std::isfinite(result_.chi2)) return result_.ended(MinimiseStatus::kNoProgress);
      if (const auto end = step()) return result_.ended(*end);
      problem_.accept();
      is_curved_ = options_.method == Method::kDogleg && (is_curved_ ? !region_.fell_short() : region_.creeps());
      if (result_.iterations >= options_.max_iterations) {
        const bool converged = options_.is_converged(region_.promise(), result_.chi2);
        return result_.ended(converged ? MinimiseStatus::kConverged : MinimiseStatus::kMaxIterations);
      }
      problem_.linearise();
    }
  }

 private:
  /// Finds a step that is accepted, and leaves it as the candidate; otherwise returns how the steps end.
  std::optional<MinimiseStatus> step() {
    const auto& metric = metric_of_();
    if (region_.may_repeat(result_.chi2)) region_.propose_repeated(newton_step(problem_, 0.0, metric));
    do {
      if (stop_.stop_requested()) return MinimiseStatus::kInterrupted;
      if (region_.needs_factorisation() && !factorise(metric)) return MinimiseStatus::kSingular;
      if (region_.needs_cauchy_point()) region_.set_cauchy_point(cauchy_point(problem_, metric), metric);
      if (const auto end = tried(region_.step())) return end;
    } while (!region_.accepted());
    return std::nullopt;
  }

  template <StepMetric M>
  bool factorise(const M& metric) {
    double damping = region_.damping();
    is_curved_ = is_curved_ && factorise_curved(problem_, result_.factorisations);
    if (!is_curved_) result_.singular = factorise_damped(problem_, damping, options_.damp_singular, result_.factorisations);
    if (result_.singular) return false;
    region_.set_newton_step(newton_step(problem_, damping, metric));
    return true;
  }

  std::optional<MinimiseStatus> tried(const Eigen::VectorXd& step) {
    if (!region_.is_finite()) return MinimiseStatus::kNoProgress;
    const bool is_tiny = detail::is_tiny(problem_, step, options_);
    const bool is_last = is_tiny || region_.promise() <= options_.relative_chi2 * result_.chi2 ||
                         region_.predicted_decrease() <= kRounding * result_.chi2;
    const double chi2 = problem_.try_step(step);
    if (is_last) return after_last(is_tiny, chi2);
    if (options_.method == Method::kGaussNewton && !std::isfinite(chi2)) return MinimiseStatus::kNoProgress;
    region_.judge(result_.chi2, chi2);
    if (region_.fell_short()) ++result_.short_steps;
    if (region_.accepted()) result_.moved_to(chi2);
    return std::nullopt;
  }

  /// Takes the last step even if it gains less than the rounding of chi2: it may still lead to the optimum.
  MinimiseStatus after_last(bool is_tiny, double chi2) {
    const bool converged = (is_tiny && !region_.is_truncated()) || options_.is_converged(region_.promise(), result_.chi2);
    if (chi2 <= result_.chi2 * (1.0 + kRounding)) {
      problem_.accept();
      result_.moved_to(chi2);
    }
    return converged ? MinimiseStatus::kConverged : MinimiseStatus::kNoProgress;
  }

  MetricOf metric_of_;
  P& problem_;
  const MinimiseOptions& options_;
  const std::stop_token& stop_;
  TrustRegion region_;
  MinimiseResult result_;
  bool is_curved_ = false;  // true if H is, once it is factorised, that of full Newton
};

/// The steps of a method that measures their lengths.
template <LeastSquaresProblem P>
MinimiseResult steps_of(P& problem, const MinimiseOptions& options, const std::stop_token& stop) {
  return Steps([&]() -> decltype(auto) { return problem.metric(); }, problem, options, stop).all();
}

/// Ends damped steps with an undamped factorisation and its step, so that convergence is judged as by every other method, and
/// singular variables that damping hides are found. Where that step promises more, and steps are left, dogleg goes on.
template <LeastSquaresProblem P>
MinimiseResult without_damping(P& problem, MinimiseOptions options, const std::stop_token& stop, MinimiseResult result) {
  if (result.status == MinimiseStatus::kSingular || result.status == MinimiseStatus::kInterrupted) return result;
  if (!std::isfinite(problem.linearise())) return result;
  result.singular = problem.factorise(0.0);
  ++result.factorisations;
  if (result.singular) return result.ended(MinimiseStatus::kSingular);
  const ModelStep step = newton_step(problem, 0.0, Unmeasured{});
  const bool converged = options.is_converged(step.decrease, result.chi2) || is_tiny(problem, step.v, options);
  const bool may_go_on = result.iterations < options.max_iterations;
  if (!converged && may_go_on) {
    options.method = Method::kDogleg;
    options.max_iterations -= result.iterations;
    result.append(steps_of(problem, options, stop));
    return result;
  }
  if (!converged) return result.status == MinimiseStatus::kConverged ? result.ended(MinimiseStatus::kNoProgress) : result;
  const double chi2 = problem.try_step(step.v);
  if (chi2 <= result.chi2 && may_go_on) {
    problem.accept();
    result.moved_to(chi2);
  }
  return result.ended(MinimiseStatus::kConverged);
}

}  // namespace detail

/// Minimises chi2 from the problem's estimate, which is left at the best one found (for Gauss-Newton, at the last). Each
/// accepted step counts as one iteration.
template <LeastSquaresProblem P>
MinimiseResult minimise(P& problem, const MinimiseOptions& options, const std::stop_token& stop = {}) {
  const bool is_plain = options.method == Method::kGaussNewton && !options.damp_singular;
  if (is_plain) return detail::Steps([] { return Unmeasured{}; }, problem, options, stop).all();
  auto result = detail::steps_of(problem, options, stop);
  if (options.method != Method::kLevenbergMarquardt || options.damp_singular) return result;
  return detail::without_damping(problem, options, stop, std::move(result));
}

}  // namespace mapjoin
