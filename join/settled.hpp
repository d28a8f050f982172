// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Acceptance of a join that was found by one of several schedules as the best there is.

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

/// The schedules that kAuto tries, in the order of cost, until the map is settled: by a solve as good as linear or, for the
/// first and cheapest, one that began near its optimum; otherwise two must end at the same optimum, one of them from near by.
inline constexpr std::array kWays = {Schedule::kAligned, Schedule::kTree, Schedule::kUnbalanced};

/// The largest rotation of a pose from one state to another (rad).
template <int Dim>
double largest_rotation_update(const Values<Dim>& from, const Values<Dim>& to) {
  double most = 0.0;
  for (const PoseIndex p : indices(to.poses)) {
    most = std::max(most, (from.poses[p].rotation.inverse() * to.poses[p].rotation).log().norm());
  }
  return most;
}

/// True if the last solve converged and every step gained what the model promised: there was no second minimum on the way.
inline bool was_as_good_as_linear(const MinimiseResult& solve) {
  return solve.status == MinimiseStatus::kConverged && solve.short_steps == 0;
}

/// True if the last solve, which turned a pose by at most `largest_rotation` (rad), began near the optimum to which it
/// converged.
inline bool came_from_near_by(const MinimiseResult& solve, double largest_rotation) {
  return solve.status == MinimiseStatus::kConverged && (largest_rotation < kFarFromLinear || was_as_good_as_linear(solve));
}

/// True if a solve settles the map by itself.
inline bool is_settled(Schedule way, const MinimiseResult& solve, double largest_rotation) {
  return was_as_good_as_linear(solve) || (way == kWays.front() && came_from_near_by(solve, largest_rotation));
}

/// The last solve of a join found by one of kWays.
struct SolveByWay {
  const MinimiseResult& result;
  double largest_rotation;  ///< Largest rotation of a pose in this solve (rad).
  bool& is_settled;
  std::optional<bool>& is_confirmed;
};

/// The result of the first way that settles the map, otherwise that of least chi2 once two ways have ended at the same optimum,
/// one of them from near by, or all are tried. `find(way)` gives an Expected<Found>, `solve_of(found)` its SolveByWay. Bad
/// input of the first way, or of one after a way that succeeded, is passed over: a system that is singular far from the optimum
/// need not be so elsewhere. A result that settles the map, or that two ended at so, is confirmed.
template <typename Found, typename Find, typename SolveOf>
Expected<Found> best_of_ways(const Find& find, const SolveOf& solve_of) {
  std::optional<Found> best;
  for (const Schedule way : kWays) {
    Expected<Found> found = find(way);
    if (!found && found.error().kind == ErrorKind::kBadInput && (best || way == kWays.front())) continue;
    if (!found) return found;
    const SolveByWay solve = solve_of(*found);
    solve.is_settled = is_settled(way, solve.result, solve.largest_rotation);
    solve.is_confirmed = solve.is_settled;
    if (best && is_same_chi2(solve_of(*best).result.chi2, solve.result.chi2)) {
      const SolveByWay of_best = solve_of(*best);
      const bool is_confirmed = came_from_near_by(of_best.result, of_best.largest_rotation) ||
                                came_from_near_by(solve.result, solve.largest_rotation);
      if (solve.is_settled || of_best.result.status != MinimiseStatus::kConverged) best = *std::move(found);
      if (is_confirmed) {
        solve_of(*best).is_confirmed = true;
        return *std::move(best);
      }
    } else if (!best || is_less_chi2(solve.result.chi2, solve_of(*best).result.chi2)) {
      best = *std::move(found);
    }
    if (solve_of(*best).is_settled) return *std::move(best);
  }
  return *std::move(best);
}

}  // namespace mapjoin
