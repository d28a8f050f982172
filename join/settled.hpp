// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// When a join that was found by one of several ways is taken for the best there is.

#include <algorithm>
#include <array>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/model/values.hpp>
#include <mapjoin/solve/minimise_options.hpp>

namespace mapjoin {

/// What kAuto tries, in the order of cost, until a map is settled: by a solve that was as good as linear, or (the first and
/// cheapest) began near its optimum; else two have to end at the same one, one of them from near by.
inline constexpr std::array kWays = {Schedule::kAligned, Schedule::kTree, Schedule::kUnbalanced};

/// The most that a pose is turned from one state to another (rad).
template <int Dim>
double largest_rotation_update(const Values<Dim>& from, const Values<Dim>& to) {
  double most = 0.0;
  for (const PoseIndex p : indices(to.poses)) {
    most = std::max(most, (from.poses[p].rotation.inverse() * to.poses[p].rotation).log().norm());
  }
  return most;
}

/// Whether every step of the last solve gained what the model promised: there was no second minimum on the way.
inline bool was_as_good_as_linear(const MinimiseResult& solve) {
  return solve.status == MinimiseStatus::kConverged && solve.short_steps == 0;
}

/// Whether the last solve, which turned a pose by `largest_rotation` at most, began near to where it converged.
inline bool came_from_near_by(const MinimiseResult& solve, double largest_rotation) {
  return solve.status == MinimiseStatus::kConverged && (largest_rotation < kFarFromLinear || was_as_good_as_linear(solve));
}

/// Whether a solve settles the map by itself.
inline bool is_settled(Schedule way, const MinimiseResult& solve, double largest_rotation) {
  return was_as_good_as_linear(solve) || (way == kWays.front() && came_from_near_by(solve, largest_rotation));
}

}  // namespace mapjoin
