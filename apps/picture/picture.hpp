// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Pictures of maps, as SVG: equal axes, lines, marks and ellipses of one map or of several on top of each other, with a scale
// and a legend.

#include <apps/position.hpp>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// A line seen from above: x to the right, y up (m).
using FlatLine = std::vector<Point<2>>;

/// The ellipse of a covariance, seen from above.
struct Ellipse {
  Point<2> centre;
  Point<2> half_axes;  ///< Half axes (m).
  double angle = 0.0;  ///< Angle of the first axis (rad).
};

enum class Mark { kDot, kRing, kSpeck };

/// Lines, marks and ellipses in one style.
struct Layer {
  std::string name;                  ///< Name in the legend; empty: not listed.
  std::vector<std::string> colours;  ///< SVG colours; the lines take them in turn, all else has the first.
  std::vector<FlatLine> lines;
  std::vector<Point<2>> marks;
  std::vector<Ellipse> ellipses;
  double width = 1.4;  ///< Width of lines and ellipses (pixels).
  Mark mark = Mark::kDot;
  bool is_dashed = false;
  bool is_framed = true;  ///< True if the picture holds all of it; otherwise it is cut off at the others.
};

/// The known positions in a list of poses or features, seen from above.
template <typename List>
std::vector<Point<2>> from_above(const List& list) {
  std::vector<Point<2>> flat;
  for (const auto& one : list) {
    if (const auto* place = position_of(one)) flat.push_back(place->template head<2>());
  }
  return flat;
}

/// One line per session, broken at unknown poses.
template <typename Poses>
std::vector<FlatLine> trajectory_lines(const Poses& poses, const std::vector<Session>& sessions) {
  std::vector<FlatLine> lines;
  for (const Session& session : sessions) {
    bool is_broken = true;
    for (PoseIndex pose = session.begin; pose < session.end; ++pose) {
      const auto* place = position_of(poses[pose]);
      if (place && is_broken) lines.emplace_back();
      if (place) lines.back().push_back(place->template head<2>());
      is_broken = !place;
    }
  }
  return lines;
}

/// The ellipse of `sigmas` standard deviations of a position along each axis of its covariance `P` (m²).
Ellipse ellipse(const Point<2>& centre, const Matrix<2>& P, double sigmas);

/// The layers as SVG, the first at the bottom and last in the legend. Lines are thinned, and of very many marks, ellipses
/// and lines that are no path some are left out, so that the size of the picture is bounded. The longer side of the drawing has
/// `pixels`.
std::string picture(const std::vector<Layer>& layers, double pixels = 1000.0);

}  // namespace mapjoin::apps
