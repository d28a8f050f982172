// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining local maps into one global map, with the absolute or the relative joined state (paper's VI.B, VI.C).

#include <cstdint>
#include <functional>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/continuation.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <memory>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// What is asked of a join, whatever the dimension.
struct JoinSettings {
  Schedule schedule = Schedule::kAuto;
  JoinedState state = JoinedState::kAbsolute;  ///< Coordinates of the steps.
  MinimiseOptions solver;                      ///< Of the last join, over all original maps.
  Start start = Start::kComposed;              ///< Another one is for the batch schedule only,
  bool gradual = false;                        ///< and so is following a path from there (see Continuation).
  std::uint64_t seed = 1;                      ///< Of the random start.
};

template <int Dim>
struct JoinOptions : JoinSettings {
  Pose<Dim> origin;                                        ///< Where the first pose is anchored when the World says nothing.
  const Values<Dim>* values = nullptr;                     ///< For Start::kFile: of the whole submap graph.
  std::function<void(std::size_t, std::size_t)> progress;  ///< As in ScheduleOptions.
};

/// How a local map fits into the join: its residual there, as an observation.
struct MapFit {
  PoseIndex base = 0;  ///< The pose that it starts from,
  PoseIndex end = 0;   ///< and the one that it ends at.
  double chi2 = 0.0;
  std::int64_t rows = 0;  ///< Measured ones, submap-local features left out: their residuals follow the others'.

  /// Of a larger chi2, if the map is as certain as it says. The join adapts itself to the map, so that the probability is
  /// rather too large than too small.
  double probability() const;
};

template <int Dim>
struct Join {
  MinimiseResult result;
  std::vector<PathPoint> path;                 ///< That led to its start, where it was followed.
  Schedule schedule = Schedule::kTree;         ///< That it was found by; of kAuto, the one of least chi2.
  bool is_settled = false;                     ///< Of kAuto: this solve was as good as linear, or aligned from near by.
  Values<Dim> state;                           ///< Of the whole submap graph; poses that are not joined are left at the origin.
  Table<PoseIndex, PoseIndex> poses;           ///< The poses of the joined state, ascending, by place.
  Table<FeatureIndex, FeatureIndex> features;  ///< Its features: all but the submap-local ones.
  std::vector<PoseIndex> anchored;             ///< The poses that hold the map still; empty where priors do.
  std::unique_ptr<JoiningSystem<Dim>> system;  ///< Of the last join, for polishing.
  std::vector<MapFit> maps;                    ///< Of the submap graph's maps, in their order.
  double largest_rotation = 0.0;  ///< The most that the last solve turned a pose (rad): how far from linear it was.
  std::int64_t rows = 0;          ///< Measured rows of the maps and observations, submap-local features left out.
  std::int64_t dof() const { return rows - static_cast<std::int64_t>(system->equations().size()); }
};

/// Joins a submap graph, whose parts must hang together (see check_connected). Bad input where the observations leave a pose or
/// feature undetermined, which is named by its id; kInterrupted on `stop`. When the last solve does not converge, result.status
/// says so and the state is the best found.
template <int Dim>
Expected<Join<Dim>> join(const SubmapGraph<Dim>& graph, const PoseIds& pose_ids, const FeatureIds& feature_ids,
                         const JoinOptions<Dim>& options, const std::stop_token& stop = {});

}  // namespace mapjoin
