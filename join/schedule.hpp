// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The order in which local maps are joined: all at once, map by map, or along a tree, solved on the way or only aligned.

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <stop_token>
#include <string_view>
#include <vector>

namespace mapjoin {

enum class Schedule : std::uint8_t {
  kBatch,       ///< All maps at once, from an initial value.
  kSequential,  ///< Map by map (I-SLSJF), re-solved while the estimate moves more than a threshold.
  kAligned,     ///< Along a tree without solves on the way: halves are only aligned, rigidly, by all that they share.
  kTree,        ///< Pairs of neighbours, then pairs of pairs: needs no initial value.
  kUnbalanced,  ///< An unbalanced tree, nearly map by map, at twice the cost of kTree.
  kAuto,        ///< kAligned; if that does not settle the map, kTree and kUnbalanced, too, until two agree.
};

/// The accuracy of the joins before the last one, which only have to lead into its basin of attraction.
enum class SolveOnTheWay : std::uint8_t {
  kNone,         ///< Maps stay as they were placed.
  kLoosely,      ///< To the accuracy that the next join needs.
  kByThreshold,  ///< As long as a step moves the estimate by more than 0.1 m or 0.01 rad.
};

/// The properties of a schedule that matter to the code.
struct JoinRule {
  double left_share = 0.5;  ///< Share of the maps on the left branch of the tree; 1 for one map after another.
  SolveOnTheWay solve = SolveOnTheWay::kNone;
  bool tries_hypotheses = true;  ///< Take the best of several alignments where two parts meet, otherwise the first.

  constexpr bool is_map_by_map() const { return left_share == 1.0; }
  /// True if the schedule accepts a given initial value, in place of maps aligned without a choice.
  constexpr bool takes_start() const { return !tries_hypotheses; }
};

/// A schedule with its name and rule; kAuto has the rule of kAligned, which it tries first.
struct ScheduleRow {
  Schedule schedule;
  std::string_view name;
  JoinRule rule;
};

inline constexpr auto kSchedules = std::to_array<ScheduleRow>({
    {Schedule::kAuto, "auto", {0.5, SolveOnTheWay::kNone, true}},
    {Schedule::kAligned, "aligned", {0.5, SolveOnTheWay::kNone, true}},
    {Schedule::kTree, "tree", {0.5, SolveOnTheWay::kLoosely, true}},
    {Schedule::kUnbalanced, "unbalanced", {0.9, SolveOnTheWay::kLoosely, true}},
    {Schedule::kSequential, "sequential", {1.0, SolveOnTheWay::kByThreshold, true}},
    {Schedule::kBatch, "batch", {0.5, SolveOnTheWay::kNone, false}},
});

constexpr auto enum_names(Schedule) {
  std::array<EnumName<Schedule>, kSchedules.size()> names{};
  std::ranges::transform(kSchedules, names.begin(), [](const ScheduleRow& row) {
    return EnumName<Schedule>{row.schedule, row.name};
  });
  return names;
}

constexpr const JoinRule& rule_of(Schedule schedule) {
  return std::ranges::find(kSchedules, schedule, &ScheduleRow::schedule)->rule;
}

/// The solver options of a join before the last one.
MinimiseOptions solver_of(SolveOnTheWay solve);

struct ScheduleOptions {
  Schedule schedule = Schedule::kTree;
  JoinedState state = JoinedState::kAbsolute;  ///< Coordinates of the steps.
  /// Called after every join with the number done and to do; from one thread at a time.
  std::function<void(std::size_t, std::size_t)> progress;
};

/// The partial maps that remain, one if all could be tied together, and the closures between them.
template <int Dim>
struct JoinedPartialMaps {
  std::vector<PartialMap<Dim>> partials;
  std::vector<const PoseFactor<Dim>*> pending;
};

/// Joins all segments of a submap graph except for the last solve, for which the partial maps hold a start; there is one if the
/// submap graph is connected. Each is in the frame of its first pose. Runs in parallel along the tree, with the same result for
/// any number of threads.
template <int Dim>
JoinedPartialMaps<Dim> join_segments(const SubmapGraph<Dim>& graph, const ScheduleOptions& options,
                                     const std::stop_token& stop = {});

/// Called with the number of segments joined so far and the resulting partial maps; the last join, of all segments, is not
/// solved yet.
template <int Dim>
using JoinWatch = std::function<void(std::size_t segments, const JoinedPartialMaps<Dim>& joined)>;

/// Joins as Schedule::kSequential, and calls `watch` after each join: of segment after segment, or of lots of `at_once` ≥ 1,
/// each of which is joined along a tree first.
template <int Dim>
void watch_join(const SubmapGraph<Dim>& graph, std::size_t at_once, const JoinWatch<Dim>& watch,
                const std::function<void(std::size_t, std::size_t)>& progress = nullptr, const std::stop_token& stop = {});

}  // namespace mapjoin
