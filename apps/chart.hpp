// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Charts of curves, as SVG fit for a paper: the same bytes for the same data, in colours that most eyes can tell apart.

#include <apps/chart_scale.hpp>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// A point of a curve, with the ends of its uncertainty where it has one: a bar at a marker, else a part of a band.
struct CurvePoint {
  double x = 0.0;
  double y = 0.0;
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

enum class Line { kSolid, kDashed, kNone };

struct Curve {
  std::string name;  ///< In the legend; a curve without a name is not there.
  std::vector<CurvePoint> points;
  Line line = Line::kSolid;
  bool has_markers = false;
  std::optional<std::size_t> colour = std::nullopt;  ///< Curves of one number share a colour; else each has its own.
};

/// Points that an axis does not take, not finite ones among them, are left out, and their line is broken there.
struct Chart {
  std::string title;
  Axis x;
  Axis y;
  std::vector<Curve> curves;
  double width = 480.0;  ///< Of the whole, in pixels; the legend, below the plot, adds to the height.
  double height = 320.0;
};

std::string svg(const Chart& chart);

/// Side by side in so many columns (at least one), row after row. Curves of one name may have one legend: name them in one
/// chart.
std::string svg(const std::vector<Chart>& charts, std::size_t columns);

}  // namespace mapjoin::apps
