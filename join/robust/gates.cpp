// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/robust/gates.hpp>
#include <mapjoin/measure/statistics.hpp>

namespace mapjoin {
namespace {

/// A scale is believed of so many tests, at these quantiles, and no less than the least one.
constexpr std::size_t kLeastTests = 20;
constexpr double kQuantiles[] = {0.5, 0.9, 0.95};
constexpr double kLeastScale = 0.001;
/// So many times fewer than one wrong measurement, or than there are to be gained, lie within a gate by chance.
constexpr double kClear = 10.0;
/// The least factor by which the numbers of wrong ones grow with twice the distance.
constexpr double kLeastGrowth = 2.0;
/// Of the squared widths of gates that are tried.
constexpr double kGateRatio = 1.2;

}  // namespace

double scale_of(std::span<const PartTest> tests, int rows) {
  std::vector<double> chi2;
  for (const PartTest& test : tests) {
    if (test.rows == rows) chi2.push_back(test.chi2);
  }
  if (chi2.size() < kLeastTests) return 1.0;
  std::ranges::sort(chi2);
  const auto count = static_cast<double>(chi2.size());
  double scale = 0.0;
  for (const double p : kQuantiles) {
    scale = std::max(scale, chi2[static_cast<std::size_t>(p * count)] / chi_squared_quantile(p, rows));
  }
  return std::clamp((1.0 + std::sqrt(6.0 / count)) * scale, kLeastScale, 1.0);
}

double gate_among(std::vector<double> distances, double narrow, double wide, int dof) {
  std::ranges::sort(distances);
  const auto within = [&](double gate) {
    return static_cast<double>(std::ranges::upper_bound(distances, gate) - distances.begin());
  };
  // Wrong ones within a gate, as their numbers up to twice and to four times its width go on inwards. A few of them tell
  // little: to begin with, they are taken to fill all dimensions.
  const double most_growth = std::pow(2.0, dof);
  const auto wrong = [&](double gate) {
    const double near = within(4.0 * gate) - within(gate);
    const double far = within(16.0 * gate) - within(4.0 * gate);
    return near / (std::clamp((far + most_growth) / (near + 1.0), kLeastGrowth, most_growth) - 1.0);
  };
  const auto is_clear = [&](double gate) { return kClear * wrong(gate) <= std::max(1.0, within(gate) - within(narrow)); };
  for (double gate = wide; gate > narrow; gate /= kGateRatio) {
    if (is_clear(gate)) return gate;
  }
  return narrow;
}

}  // namespace mapjoin
