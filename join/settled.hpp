// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Acceptance of a join that was found by one of several schedules as the best there is.

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/values.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <optional>
#include <utility>

namespace mapjoin {

/// The schedules that kAuto tries, in the order of cost, until the map is settled: by a solve that kept its promises or, for
/// the first and cheapest, one that began near its optimum; otherwise two must end at the same optimum, one of them from near
/// by.
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

/// The last solve of a join, and whether it is settled and confirmed that there is no better optimum.
struct JoinResult : MinimiseResult {
  std::int64_t dof = 0;                   ///< Measured rows less free variables.
  Schedule schedule = Schedule::kTree;    ///< Schedule that found the join; for kAuto the one of least chi2.
  double largest_rotation = 0.0;          ///< Largest rotation of a pose (rad): how far from linear the solve was.
  bool is_settled = false;                ///< For kAuto: this join settles the map by itself (see settles()).
  std::optional<bool> is_confirmed = {};  ///< For kAuto: whether the ways that were tried confirm this optimum.

  /// True if it converged, every step gained what the model promised, so that there was no second minimum on the way, and chi2
  /// is not larger than its degrees of freedom allow, as in a minimum into which every step led.
  bool kept_its_promises() const {
    return status == MinimiseStatus::kConverged && short_steps == 0 &&
           chi_squared_upper_tail(chi2, static_cast<double>(dof)) >= kLeastJoinProbability;
  }
  /// True if it began near the optimum to which it converged.
  bool came_from_near_by() const {
    return status == MinimiseStatus::kConverged && (largest_rotation < kFarFromLinear || kept_its_promises());
  }
  /// True if it settles the map by itself.
  bool settles() const { return kept_its_promises() || (schedule == kWays.front() && came_from_near_by()); }
};

/// The result of the first way that settles the map, otherwise that of least chi2 once two ways have ended at the same optimum,
/// one of them from near by, or all are tried. `find(way)` gives an Expected<Found>, `result_of` a reference to the JoinResult
/// of a Found. Bad input of the first way, or of one after a way that succeeded, is passed over: a system that is singular far
/// from the optimum need not be so elsewhere. A result that settles the map, or that two ended at so, is confirmed.
template <typename Found, typename Find, typename ResultOf>
Expected<Found> best_of_ways(const Find& find, const ResultOf& result_of) {
  std::optional<Found> best;
  for (const Schedule way : kWays) {
    Expected<Found> found = find(way);
    if (!found && found.error().kind == ErrorKind::kBadInput && (best || way == kWays.front())) continue;
    if (!found) return found;
    JoinResult& result = std::invoke(result_of, *found);
    result.is_settled = result.settles();
    result.is_confirmed = result.is_settled;
    if (best && is_same_chi2(std::invoke(result_of, *best).chi2, result.chi2)) {
      const JoinResult& of_best = std::invoke(result_of, *best);
      const bool is_confirmed = of_best.came_from_near_by() || result.came_from_near_by();
      if (result.is_settled || of_best.status != MinimiseStatus::kConverged) best = *std::move(found);
      if (is_confirmed) {
        std::invoke(result_of, *best).is_confirmed = true;
        return *std::move(best);
      }
    } else if (!best || is_less_chi2(result.chi2, std::invoke(result_of, *best).chi2)) {
      best = *std::move(found);
    }
    if (std::invoke(result_of, *best).is_settled) return *std::move(best);
  }
  return *std::move(best);
}

}  // namespace mapjoin
