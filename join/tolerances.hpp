// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Where the lines are drawn between "the same" and "another", and why there.

#include <algorithm>
#include <cmath>

namespace mapjoin {

/// Two optima whose chi2 differs by at most this share of it (or by so much, below 1) are one. Solves that have converged
/// differ by less than a hundredth of it; neighbouring minima of logs that were made to be hard, by a hundred times as much and
/// more.
constexpr double kSameChi2 = 1e-6;

inline bool is_same_chi2(double a, double b) {
  return std::abs(a - b) <= kSameChi2 * std::max(1.0, std::min(a, b));
}

/// Whether `a` is of another optimum than `b`, and a better one; one that is not finite is never.
inline bool is_less_chi2(double a, double b) {
  return std::isfinite(a) && !(b <= a) && !is_same_chi2(a, b);
}

/// A solve that turns a pose further (rad) has left the part of space where the rotations, all that is not linear in a map,
/// are nearly so: real logs stay below 0.6, and where aligning ends in a local minimum it turned a pose by 2 and more.
constexpr double kFarFromLinear = 1.0;

/// A growth of chi2, by the k-th map that is added, that is less probable than this, and than 1/k², asks for another look: of
/// however many maps, less than one in ten times asks in vain.
constexpr double kLeastGrowthProbability = 1e-3;

/// Local maps are crude where refining lowers chi2 of what they recovered by more than this share. In simulated worlds it is
/// less than 0.006 with odometry ten times as noisy as usual, where joining finds the optimum, and 0.016 (median) with thirty
/// times as much, where it may not.
constexpr double kCrudeMaps = 0.02;

/// Refining goes on until a step promises this share of what ends a join: near the optimum that is one step more, and the map
/// is the same to the micrometre however the log was split.
constexpr double kRefiningShare = 1e-3;

}  // namespace mapjoin
