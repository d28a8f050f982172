// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/robust/gates.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <ranges>

namespace mapjoin {
namespace {

/// A scale is believed of so many tests, at these quantiles, and no less than the least one.
constexpr std::size_t kLeastTests = 20;
constexpr double kQuantiles[] = {0.5, 0.9, 0.95};
constexpr double kLeastScale = 0.02;
/// So many times more measurements than wrong ones by chance lie within a gate.
constexpr double kClear = 10.0;

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
  const double share = 1.0 / (std::pow(2.0, dof) - 1.0);  // of the volumes within a gate and up to twice its width
  const auto is_clear = [&](double gate) {
    return kClear * share * (within(4.0 * gate) - within(gate)) <= within(gate) - within(narrow);
  };
  if (is_clear(wide)) return wide;
  for (const double gate : std::views::reverse(distances)) {
    if (narrow < gate && gate < wide && is_clear(gate)) return gate;
  }
  return narrow;
}

}  // namespace mapjoin
