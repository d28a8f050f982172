// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How convex a function is along a segment (paper's (12) and Fig. 4).

#include <cstddef>
#include <functional>
#include <vector>

namespace mapjoin {

/// F at so many equally spaced λ from 0 to 1, both among them; at least three. In parallel.
std::vector<double> sampled(const std::function<double(double)>& F, std::size_t points);

/// What speaks against convexity, over the inner points of the samples of one or several segments. Rounding is allowed for: a
/// difference counts where it is more than kCurvatureTolerance of the largest |F| of its segment.
struct CurvatureFigures {
  std::size_t points = 0;
  std::size_t violations = 0;      ///< Where (12), F(λX + (1-λ)Y) ≤ λF(X) + (1-λ)F(Y), does not hold.
  double largest_violation = 0.0;  ///< By what share F is above its chord at the most, of the larger of its ends.
  std::size_t negative = 0;        ///< Where the second difference is below zero: the curvature d²F/dλ² is.

  double share_violated() const { return share(violations); }
  double share_negative() const { return share(negative); }
  /// Those of both.
  void add(const CurvatureFigures& other);

 private:
  double share(std::size_t count) const { return points == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(points); }
};

inline constexpr double kCurvatureTolerance = 1e-10;

/// Of one segment, from equally spaced samples; `values` with fewer than three has no inner points. A value that is not finite
/// violates, and its neighbours have no curvature to speak of.
CurvatureFigures curvature_figures(const std::vector<double>& values);

}  // namespace mapjoin
