// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/measure/curvature.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <stdexcept>

namespace mapjoin {

std::vector<double> sampled(const std::function<double(double)>& F, std::size_t points) {
  if (points < 3) throw std::invalid_argument("sampled: a segment has an inner point from three points on");
  std::vector<double> values(points);
  parallel_for(points, [&](std::size_t k) { values[k] = F(static_cast<double>(k) / static_cast<double>(points - 1)); });
  return values;
}

void CurvatureFigures::add(const CurvatureFigures& other) {
  points += other.points;
  violations += other.violations;
  largest_violation = std::max(largest_violation, other.largest_violation);
  negative += other.negative;
}

CurvatureFigures curvature_figures(const std::vector<double>& values) {
  CurvatureFigures figures;
  if (values.size() < 3) return figures;
  double largest = 0.0;
  for (const double value : values) {
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  }
  const double tolerance = kCurvatureTolerance * largest;
  const double ends = std::max(std::abs(values.front()), std::abs(values.back()));
  const auto last = static_cast<double>(values.size() - 1);
  const std::size_t reach = std::max<std::size_t>(1, (values.size() - 1 + kCurvatureParts / 2) / kCurvatureParts);
  figures.points = values.size() - 2;
  for (std::size_t k = 1; k + 1 < values.size(); ++k) {
    const double lambda = static_cast<double>(k) / last;
    const double excess = values[k] - (lambda * values.back() + (1.0 - lambda) * values.front());
    if (!(excess <= tolerance)) {
      ++figures.violations;
      figures.largest_violation = std::max(figures.largest_violation, excess / ends);
    }
    const std::size_t at = std::clamp(k, reach, values.size() - 1 - reach);
    if (values[at - reach] - 2.0 * values[at] + values[at + reach] < -tolerance) ++figures.negative;
  }
  return figures;
}

}  // namespace mapjoin
