// SPDX-License-Identifier: BSD-3-Clause
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>
#include <mapjoin/measure/statistics.hpp>

namespace mapjoin {
namespace {

namespace policies = boost::math::policies;

/// The distribution with an infinite Γ instead of overflow: right for thousands of degrees of freedom, since others are divided
/// by it.
using ChiSquared =
    boost::math::chi_squared_distribution<double, policies::policy<policies::overflow_error<policies::ignore_error>>>;

/// The relative rounding of a ratio.
constexpr double kRounding = 1e-9;

/// The value, or the largest double if it is infinite.
double finite(double value) {
  return std::min(value, std::numeric_limits<double>::max());
}

}  // namespace

double weighted_median(std::vector<Weighted> values) {
  std::ranges::sort(values, {}, &Weighted::value);
  double half = 0.0;
  for (const Weighted& one : values) half += 0.5 * one.weight;
  double reached = 0.0;
  auto middle = values.begin();
  while ((reached += middle->weight) < half) ++middle;
  return middle->value;
}

std::int64_t whole_part(double ratio) {
  return static_cast<std::int64_t>(ratio * (1.0 + kRounding));
}

bool is_whole(double ratio) {
  return std::abs(ratio - std::round(ratio)) <= kRounding * ratio;
}

double chi_squared_upper_tail(double value, double dof) {
  if (std::isnan(value)) return value;
  if (dof <= 0.0) return 1.0;
  return boost::math::cdf(boost::math::complement(ChiSquared(dof), finite(std::max(0.0, value))));
}

double log_chi_squared_upper_tail(double value, double dof) {
  const double tail = chi_squared_upper_tail(value, dof);
  if (tail > std::numeric_limits<double>::min()) return std::log(tail);
  // Q(a, x) = xᵃ⁻¹ e⁻ˣ / Γ(a) (1 + (a - 1)/x + …), a = dof/2, x = value/2.
  const double a = 0.5 * dof;
  const double x = 0.5 * finite(value);
  return (a - 1.0) * std::log(x) - x - std::lgamma(a) + std::log1p((a - 1.0) / x);
}

double chi_squared_quantile(double p, double dof) {
  if (dof <= 0.0) return 0.0;
  return boost::math::quantile(ChiSquared(dof), p);
}

double chi_squared_upper_quantile(double tail, double dof) {
  if (dof <= 0.0) return 0.0;
  return boost::math::quantile(boost::math::complement(ChiSquared(dof), tail));
}

}  // namespace mapjoin
