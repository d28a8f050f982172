// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// In which order local maps are joined: all at once, map by map, or along a tree, solved on the way or only aligned.

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
  kAligned,     ///< As kTree, but nothing is solved on the way: halves are only placed, rigidly, by all that they share.
  kTree,        ///< Pairs of neighbours, then pairs of pairs: needs no initial value.
  kUnbalanced,  ///< An unbalanced tree, nearly map by map, at twice the cost of kTree.
  kAuto,        ///< Aligned; where that was not nearly linear, along a tree, too, and an unbalanced one, until two agree.
};

/// How far the joins before the last one are solved, which only have to lead to its basin.
enum class SolveOnTheWay : std::uint8_t {
  kNone,         ///< Maps stay as they were placed.
  kLoosely,      ///< To the accuracy that the next join needs.
  kByThreshold,  ///< As long as a step moves the estimate by more than 0.1 m or 0.01 rad.
};

/// What makes a schedule: all that the code asks of one.
struct JoinRule {
  double left_share = 0.5;  ///< Share of the maps on the left branch of the tree; 1 for one map after another.
  SolveOnTheWay solve = SolveOnTheWay::kNone;
  bool tries_hypotheses = true;  ///< The best of several alignments where two parts meet, else the first.

  constexpr bool is_map_by_map() const { return left_share == 1.0; }
  /// Maps that are placed without a choice are an initial value like others.
  constexpr bool takes_start() const { return !tries_hypotheses; }
};

/// A schedule, its word, and its rule; that of kAuto is its first one's.
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

/// When a join on the way ends.
MinimiseOptions solver_of(SolveOnTheWay solve);

struct ScheduleOptions {
  Schedule schedule = Schedule::kTree;
  JoinedState state = JoinedState::kAbsolute;  ///< Coordinates of the steps.
  /// Called after every join with the number done and to do; from one thread at a time.
  std::function<void(std::size_t, std::size_t)> progress;
};

/// Partial maps that could not be tied together, and the closures between them.
template <int Dim>
struct JoinedPartialMaps {
  std::vector<PartialMap<Dim>> partials;
  std::vector<const PoseFactor<Dim>*> pending;
};

/// Joins all segments of a submap graph but for the last solve: the partial maps, one where the submap graph hangs together,
/// hold a start for it. Each is in the frame of its first pose. In parallel along the tree, with the same result for any number
/// of threads.
template <int Dim>
JoinedPartialMaps<Dim> join_segments(const SubmapGraph<Dim>& graph, const ScheduleOptions& options,
                                     const std::stop_token& stop = {});

/// Told how many segments are joined, and what came of them; the last join is not yet solved.
template <int Dim>
using JoinWatch = std::function<void(std::size_t segments, const JoinedPartialMaps<Dim>& joined)>;

/// Joins as Schedule::kSequential does, for it to be watched: segment after segment, or `at_once` of them each time, which are
/// joined along a tree before. From 1 on.
template <int Dim>
void watch_join(const SubmapGraph<Dim>& graph, std::size_t at_once, const JoinWatch<Dim>& watch,
                const std::function<void(std::size_t, std::size_t)>& progress = nullptr, const std::stop_token& stop = {});

}  // namespace mapjoin
