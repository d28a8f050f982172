// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// When a join that was found by one of several ways is taken for the best there is.

#include <algorithm>
#include <array>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/values.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <optional>
#include <utility>

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

/// The solve of what was found by one of the ways.
struct SolveByWay {
  const MinimiseResult& result;
  double largest_rotation;  ///< The most that it turned a pose (rad).
  bool& is_settled;
};

/// What is found by the first way that settles it, or else that of least chi2, once two ways have ended at the same optimum,
/// one of them from near by, or all are tried. `find(way)` gives an Expected<Found>, `solve_of(found)` its SolveByWay. What is
/// singular far from the optimum need not be so elsewhere: another way is tried after the first, and after one that was found.
template <typename Found, typename Find, typename SolveOf>
Expected<Found> best_of_ways(const Find& find, const SolveOf& solve_of) {
  std::optional<Found> best;
  for (const Schedule way : kWays) {
    Expected<Found> found = find(way);
    if (!found && found.error().kind == ErrorKind::kBadInput && (best || way == kWays.front())) continue;
    if (!found) return found;
    const SolveByWay solve = solve_of(*found);
    solve.is_settled = is_settled(way, solve.result, solve.largest_rotation);
    if (best && is_same_chi2(solve_of(*best).result.chi2, solve.result.chi2)) {
      const SolveByWay of_best = solve_of(*best);
      const bool is_confirmed = came_from_near_by(of_best.result, of_best.largest_rotation) ||
                                came_from_near_by(solve.result, solve.largest_rotation);
      if (solve.is_settled || of_best.result.status != MinimiseStatus::kConverged) best = *std::move(found);
      if (is_confirmed) return *std::move(best);
    } else if (!best || is_less_chi2(solve.result.chi2, solve_of(*best).result.chi2)) {
      best = *std::move(found);
    }
    if (solve_of(*best).is_settled) return *std::move(best);
  }
  return *std::move(best);
}

}  // namespace mapjoin
