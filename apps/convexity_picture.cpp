// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/chart.hpp>
#include <apps/convexity_report.hpp>
#include <cmath>
#include <mapjoin/measure/observation_curvature.hpp>
#include <numbers>
#include <utility>

namespace mapjoin::apps {
namespace {

Curve curve_of(const LineOfStates& line) {
  const double larger = std::max(line.values.front(), line.values.back());
  Curve curve;
  for (std::size_t k = 0; k < line.values.size(); ++k) {
    const double lambda = static_cast<double>(k) / static_cast<double>(line.values.size() - 1);
    curve.points.push_back({lambda, line.values[k] / larger});
  }
  return curve;
}

std::string title_of(const Formulation& formulation) {
  std::string title = to_string(formulation) + " state";
  title.front() = formulation.is_joining ? 'J' : 'F';
  return title;
}

}  // namespace

std::string convexity_picture(const Convexity& found) {
  std::vector<Chart> panels;
  for (const FormulationFigures& figures : found) {
    Chart panel;
    panel.title = title_of(figures.formulation);
    panel.x = {.label = "λ", .low = 0.0, .high = 1.0};
    panel.y = {.label = "F(λX + (1-λ)Y) / larger end", .low = 0.0};
    for (const LineOfStates& line : figures.segments) panel.curves.push_back(curve_of(line));
    panels.push_back(std::move(panel));
  }
  return svg(panels, 2);
}

std::string region_picture() {
  constexpr double kFarthest = 3.0;  // |δ| / |Z| that is shown
  Chart chart;
  chart.title = "Where the term of one observation is convex: above the curve";
  chart.x = {.label = "heading error φ, from the direction of δ (degrees)", .low = -90.0, .high = 90.0};
  chart.y = {.label = "|δ| / |Z|", .low = 0.0, .high = kFarthest};
  chart.width = 560.0;
  chart.height = 400.0;
  // The ratio of σ_φ to σ/|Z|.
  const std::vector<std::pair<double, std::string>> headings = {
      {INFINITY, "heading unknown"}, {2.0, "σφ = 2 σ/|Z|"}, {1.5, "σφ = 1.5 σ/|Z|"}, {1.2, "σφ = 1.2 σ/|Z|"}};
  for (const auto& [ratio, name] : headings) {
    Curve curve;
    curve.name = name;
    const ObservationTerm term{{1.0, 0.0}, 1.0 / (ratio * ratio)};
    for (int degrees = -89; degrees <= 89; ++degrees) {
      const double border = term.border(degrees * std::numbers::pi / 180.0);
      CurvePoint point{static_cast<double>(degrees), border};
      if (std::isinf(ratio) && border <= kFarthest) {
        point.low = border;
        point.high = kFarthest;
      }
      curve.points.push_back(point);
    }
    chart.curves.push_back(std::move(curve));
  }
  return svg(chart);
}

}  // namespace mapjoin::apps
