// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// In which order local maps are joined: all at once, map by map, or along a tree, solved on the way or only aligned.

#include <cstdint>
#include <functional>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/piece.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

enum class Schedule : std::uint8_t {
  kBatch,       ///< All maps at once, from an initial value.
  kSequential,  ///< Map by map (I-SLSJF), re-solved while the estimate moves more than a threshold.
  kAligned,     ///< As kTree, but nothing is solved on the way: halves are only placed, rigidly, by all that they share.
  kTree,        ///< Pairs of neighbours, then pairs of pairs: needs no initial value.
  kLeaning,     ///< A tree with nine tenths of the maps on its left branches: nearly map by map, at twice the cost of kTree.
  kAuto,        ///< Aligned; where that was not nearly linear, along a tree, too, and a leaning one, until two agree.
};

constexpr auto enum_names(Schedule) {
  return std::to_array<EnumName<Schedule>>({{Schedule::kAuto, "auto"},
                                            {Schedule::kAligned, "aligned"},
                                            {Schedule::kTree, "tree"},
                                            {Schedule::kLeaning, "leaning"},
                                            {Schedule::kSequential, "sequential"},
                                            {Schedule::kBatch, "batch"}});
}

struct ScheduleOptions {
  Schedule schedule = Schedule::kTree;         ///< Not kAuto, which is several of the others.
  JoinedState state = JoinedState::kAbsolute;  ///< Coordinates of the steps.
  MinimiseOptions inner;                       ///< Of the joins below the last one, which only have to lead to its basin.
  /// Called after every join with the number done and to do; from one thread at a time.
  std::function<void(std::size_t, std::size_t)> progress;

  /// For the joins below the last one: one step where that moves little, more where it moves the estimate beyond a threshold
  /// (map by map, 0.1 m or 0.01 rad).
  static MinimiseOptions leading(Schedule schedule);
};

/// Pieces that could not be tied together, and the closures between them.
template <int Dim>
struct JoinedPieces {
  std::vector<Piece<Dim>> pieces;
  std::vector<const PoseObservation<Dim>*> pending;
};

/// Joins all stretches of a network but for the last solve: the pieces, one where the network hangs together, hold a start for
/// it. Each is in the frame of its first pose. In parallel along the tree, with the same result for any number of threads.
template <int Dim>
JoinedPieces<Dim> join_stretches(const Network<Dim>& network, const ScheduleOptions& options, const std::stop_token& stop = {});

/// Told how many stretches are joined, and what came of them; the last join is not yet solved.
template <int Dim>
using JoinWatch = std::function<void(std::size_t stretches, const JoinedPieces<Dim>& joined)>;

/// Joins as Schedule::kSequential does, for it to be watched: stretch after stretch, or `at_once` of them each time, which are
/// joined along a tree before. From 1 on.
template <int Dim>
void watch_join(const Network<Dim>& network, std::size_t at_once, const JoinWatch<Dim>& watch,
                const std::function<void(std::size_t, std::size_t)>& progress = nullptr, const std::stop_token& stop = {});

}  // namespace mapjoin
