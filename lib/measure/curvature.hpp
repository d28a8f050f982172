// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Convexity of a function along a segment (paper's (12) and Fig. 4).

#include <cstddef>
#include <functional>
#include <vector>

namespace mapjoin {

/// F at equally spaced λ from 0 to 1, both included; at least three points. In parallel.
std::vector<double> sampled(const std::function<double(double)>& F, std::size_t points);

/// Evidence against convexity, over the inner points of the samples of one or several segments. To allow for rounding, a
/// difference counts only if it exceeds kCurvatureTolerance of the largest |F| of its segment.
struct CurvatureFigures {
  std::size_t points = 0;
  std::size_t violations = 0;      ///< Points at which (12), F(λX + (1-λ)Y) ≤ λF(X) + (1-λ)F(Y), does not hold.
  double largest_violation = 0.0;  ///< The largest excess of F over its chord, relative to the larger of its ends.
  /// Points with negative curvature d²F/dλ², by the second difference to the samples about 1/kCurvatureParts of the segment
  /// away, or next to it where these are farther: over less the tolerance would hide it. Near the ends the nearest point counts
  /// that has both.
  std::size_t negative = 0;

  double share_violated() const { return share(violations); }
  double share_negative() const { return share(negative); }
  /// Adds the figures of other segments.
  void add(const CurvatureFigures& other);

 private:
  double share(std::size_t count) const { return points == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(points); }
};

inline constexpr double kCurvatureTolerance = 1e-10;
inline constexpr std::size_t kCurvatureParts = 100;

/// The figures of one segment, from equally spaced samples; fewer than three have no inner points. A value that is NaN or +∞
/// violates (12), and no curvature counts at the points whose second differences reach it.
CurvatureFigures curvature_figures(const std::vector<double>& values);

}  // namespace mapjoin
