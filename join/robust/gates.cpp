// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/robust/gates.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// A scale is believed of so many tests, at these quantiles.
constexpr std::size_t kLeastTests = 20;
constexpr double kQuantiles[] = {0.5, 0.9, 0.95};

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

}  // namespace mapjoin
