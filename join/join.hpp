// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining local maps into one global map, with the absolute or the relative joined state (paper's VI.B, VI.C).

#include <cstdint>
#include <functional>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/continuation.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/join/settled.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Settings of a join that do not depend on the dimension.
struct JoinSettings {
  Schedule schedule = Schedule::kAuto;
  JoinedState state = JoinedState::kAbsolute;  ///< Coordinates of the steps.
  MinimiseOptions solver;                      ///< Solver of the last join, over all original maps.
  Start start = Start::kComposed;              ///< Initial value; any other is for the batch schedule only.
  bool gradual = false;    ///< Follow a path from the start (see Continuation); for the batch schedule only.
  std::uint64_t seed = 1;  ///< Seed of the random start.
};

template <int Dim>
struct JoinOptions : JoinSettings {
  Pose<Dim> origin;                     ///< Anchor of the first pose if neither priors nor fixed poses place the map.
  const Values<Dim>* values = nullptr;  ///< Values of the whole submap graph, for Start::kFile.
  std::function<void(std::size_t, std::size_t)> progress;  ///< Called as ScheduleOptions::progress.
};

/// The fit of a local map in the join: its chi2 there as one observation.
struct MapFit {
  PoseIndex base = 0;  ///< Start pose of the map.
  PoseIndex end = 0;   ///< End pose of the map; its start if it keeps no other.
  double chi2 = 0.0;
  std::int64_t rows = 0;  ///< Measured rows without those of submap-local features, whose residuals follow from the others.

  /// The probability of a larger chi2 if the information of the map is right. It tends to be too large, as the join adapts
  /// itself to the map.
  double probability() const;
};

template <int Dim>
struct Join {
  JoinResult result;
  std::vector<PathPoint> path;        ///< Path that led to the start; empty if none was followed.
  Values<Dim> state;                  ///< State of the whole submap graph; poses that are not joined stay at the origin.
  Table<PoseIndex, PoseIndex> poses;  ///< The poses of the joined state, ascending, by place.
  Table<FeatureIndex, FeatureIndex> features;  ///< The joined features, all but the submap-local ones, ascending, by place.
  std::vector<PoseIndex> anchored;             ///< Anchored poses, the gauge of the map; empty if priors hold it.
  std::unique_ptr<JoiningSystem<Dim>> system;  ///< System of the last join, for polishing.
  std::vector<MapFit> maps;                    ///< Fits of the submap graph's maps, in their order.
};

/// Joins a submap graph, which must be connected (see check_connected). Bad input, with the id, if the observations leave a
/// pose or feature undetermined; kInterrupted on `stop`. If the last solve does not converge, result.status says so and the
/// state is the best found.
template <int Dim>
Expected<Join<Dim>> join(const SubmapGraph<Dim>& graph, const PoseIds& pose_ids, const FeatureIds& feature_ids,
                         const JoinOptions<Dim>& options, const std::stop_token& stop = {});

}  // namespace mapjoin
