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

/// chi2(x ⊕ δ) ≈ chi2 - 2 gᵀδ + δᵀHδ.
template <typename P>
concept LeastSquaresProblem = requires(P p, const Eigen::VectorXd& v, double damping) {
  { p.linearise() } -> std::convertible_to<double>;  // makes H and g at the estimate; returns chi2 there
  {p.add_curvature()};  // makes H that of full Newton, which need not be positive definite, until linearise(); g and D stay
  { p.gradient() } -> std::convertible_to<Eigen::VectorXd>;           // g
  { p.metric() } -> StepMetric;                                       // D, at the estimate
  { p.curvature(v) } -> std::convertible_to<double>;                  // vᵀHv
  { p.factorise(damping) } -> std::same_as<std::optional<Variable>>;  // H + damping·D; a singular variable or nothing
  { p.solve() } -> std::convertible_to<Eigen::VectorXd>;  // (H + damping·D)⁻¹ g by the last factor, whatever g now is
  { p.step_size(v) } -> std::same_as<StepSize>;
  { p.try_step(v) } -> std::convertible_to<double>;  // chi2 of the estimate moved by v, kept as the candidate
  {p.accept()};                                      // the candidate becomes the estimate
};

namespace detail {

/// What rounding may add to chi2, as a share of it.
constexpr double kRounding = 1e-12;

/// The minimiser of the model along the direction of steepest descent; it has gᵀc = cᵀHc.
template <LeastSquaresProblem P, StepMetric M>
ModelStep cauchy_point(P& problem, const M& metric) {
  ModelStep point{metric.descent(problem.gradient())};
  const double curvature = problem.curvature(point.v);
  const double share = curvature > 0.0 ? problem.gradient().dot(point.v) / curvature : 0.0;
  point.v *= share;
  point.decrease = share * share * curvature;
  point.length = length(metric, point.v);
  return point;
}

/// The solution of (H + damping·D) n = g, by the last factor.
template <LeastSquaresProblem P, StepMetric M>
ModelStep newton_step(P& problem, double damping, const M& metric) {
  ModelStep step{problem.solve()};
  step.is_damped = damping > 0.0;
  step.length = length(metric, step.v);
  step.decrease = problem.gradient().dot(step.v) + damping * step.length * step.length;
  return step;
}

/// Factorises with `damping` or, if that may grow, the least that makes the system regular, which `damping` then is. Returns
/// the first singular variable met where none does. Counts.
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

/// Factorises H of full Newton; where it is not positive definite, makes it Gauss-Newton's again and returns false.
template <LeastSquaresProblem P>
bool factorise_curved(P& problem, int& factorisations) {
  ++factorisations;
  if (!problem.factorise(0.0)) return true;
  problem.linearise();
  return false;
}

inline bool is_tiny(const StepSize& size, const MinimiseOptions& options) {
  return size.metres <= options.step_metres && size.radians <= options.step_radians;
}

/// minimise() with steps measured in metric_of(), which is asked for once an estimate, before H is made full Newton's.
template <LeastSquaresProblem P, typename MetricOf>
MinimiseResult minimise_in(MetricOf&& metric_of, P& problem, const MinimiseOptions& options, const std::stop_token& stop) {
  MinimiseResult result;
  result.chi2 = result.start_chi2 = problem.linearise();
  TrustRegion region(options.method);
  bool is_curved = false;  // whether H is that of full Newton
  while (true) {
    if (!std::isfinite(result.chi2)) return result.ended(MinimiseStatus::kNoProgress);
    const auto& metric = metric_of();
    if (is_curved) problem.add_curvature();
    if (region.may_repeat(result.chi2)) region.propose_repeated(newton_step(problem, 0.0, metric));
    Eigen::VectorXd step;
    do {
      if (stop.stop_requested()) return result.ended(MinimiseStatus::kInterrupted);
      if (region.needs_factorisation()) {
        double damping = region.damping();
        is_curved = is_curved && factorise_curved(problem, result.factorisations);
        if (!is_curved) result.singular = factorise_damped(problem, damping, options.damp_singular, result.factorisations);
        if (result.singular) return result.ended(MinimiseStatus::kSingular);
        region.set_newton_step(newton_step(problem, damping, metric));
      }
      if (region.needs_cauchy_point()) region.set_cauchy_point(cauchy_point(problem, metric), metric);
      step = region.step();
      if (!region.is_finite()) return result.ended(MinimiseStatus::kNoProgress);
      const double promised = region.predicted_decrease();
      const bool tiny = is_tiny(problem.step_size(step), options);
      const bool last = tiny || region.promise() <= options.relative_chi2 * result.chi2 || promised <= kRounding * result.chi2;
      const double chi2 = problem.try_step(step);
      if (last) {
        const bool converged = (tiny && !region.is_truncated()) || options.is_converged(region.promise(), result.chi2);
        // The last step may gain less than chi2 is rounded to, and still be the one to the optimum.
        if (chi2 <= result.chi2 * (1.0 + kRounding)) {
          problem.accept();
          result.moved_to(chi2);
        }
        return result.ended(converged ? MinimiseStatus::kConverged : MinimiseStatus::kNoProgress);
      }
      if (options.method == Method::kGaussNewton && !std::isfinite(chi2)) return result.ended(MinimiseStatus::kNoProgress);
      region.judge(result.chi2, chi2);
      if (region.fell_short()) ++result.short_steps;
      if (region.accepted()) result.moved_to(chi2);
    } while (!region.accepted());
    problem.accept();
    is_curved = options.method == Method::kDogleg && (is_curved ? !region.fell_short() : region.creeps());
    if (result.iterations >= options.max_iterations) {
      const bool converged = options.is_converged(region.promise(), result.chi2);
      return result.ended(converged ? MinimiseStatus::kConverged : MinimiseStatus::kMaxIterations);
    }
    problem.linearise();
  }
}

/// What damping hides: an undamped factorisation where damped steps ended, whose step is the last one. Whether the estimate
/// converged is said of that step, as of every other method's; and what is free is found.
template <LeastSquaresProblem P>
MinimiseResult without_damping(P& problem, const MinimiseOptions& options, MinimiseResult result) {
  if (result.status == MinimiseStatus::kSingular || result.status == MinimiseStatus::kInterrupted) return result;
  if (!std::isfinite(problem.linearise())) return result;
  result.singular = problem.factorise(0.0);
  ++result.factorisations;
  if (result.singular) return result.ended(MinimiseStatus::kSingular);
  const ModelStep step = newton_step(problem, 0.0, Unmeasured{});
  const bool converged = options.is_converged(step.decrease, result.chi2) || is_tiny(problem.step_size(step.v), options);
  if (!converged) return result.status == MinimiseStatus::kConverged ? result.ended(MinimiseStatus::kNoProgress) : result;
  const double chi2 = problem.try_step(step.v);
  if (chi2 <= result.chi2 && result.iterations < options.max_iterations) {
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
  if (is_plain) return detail::minimise_in([] { return Unmeasured{}; }, problem, options, stop);
  auto result = detail::minimise_in([&]() -> decltype(auto) { return problem.metric(); }, problem, options, stop);
  if (options.method != Method::kLevenbergMarquardt || options.damp_singular) return result;
  return detail::without_damping(problem, options, std::move(result));
}

}  // namespace mapjoin
