// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The tolerances of joining, and the reasons for them.

#include <algorithm>
#include <cmath>

namespace mapjoin {

/// The largest relative difference in chi2 (absolute below 1) at which two optima count as the same. Converged solves differ by
/// less than a hundredth of it, neighbouring minima of logs that were made to be hard by a hundred times as much or more.
constexpr double kSameChi2 = 1e-6;

inline bool is_same_chi2(double a, double b) {
  return std::abs(a - b) <= kSameChi2 * std::max(1.0, std::min(a, b));
}

/// True if chi2 `a` is finite, and that of another and better optimum than chi2 `b`.
inline bool is_less_chi2(double a, double b) {
  return std::isfinite(a) && !(b <= a) && !is_same_chi2(a, b);
}

/// The rotation of a pose (rad) beyond which a solve has left the region where rotations, the only nonlinear part of a map, are
/// nearly linear: real logs stay below 0.6, and solves of aligned maps that ended in a local minimum turned a pose by 2 or
/// more.
constexpr double kFarFromLinear = 1.0;

/// The probability of a larger chi2 below which a solve is not believed on the gains of its steps alone: a right one is solved
/// anew in a thousandth of cases.
constexpr double kLeastJoinProbability = 1e-3;

/// The probability below which, and below 1/k², a growth of chi2 by the k-th map that is added asks for a join of all: for any
/// number of maps, the expected number of needless requests is below 0.1.
constexpr double kLeastGrowthProbability = 1e-3;

/// The share of chi2 by which refining must lower that of the recovered estimate for local maps to count as crude. In simulated
/// worlds it is below 0.006 with odometry ten times as noisy as usual, where joining finds the optimum, and 0.016 (median) with
/// thirty times as much, where it may not.
constexpr double kCrudeMaps = 0.02;

/// The share of a join's convergence threshold at which refining ends: near the optimum that is one step more, and the map is
/// the same to the micrometre however the log was split.
constexpr double kRefiningShare = 1e-3;

}  // namespace mapjoin
