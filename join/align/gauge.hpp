// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The placement of a partial map in the World, and its gauge.

#include <mapjoin/join/align/partial_map.hpp>
#include <vector>

namespace mapjoin {

/// The gauge of a partial map: the poses and priors that hold it still.
template <int Dim>
struct Gauge {
  std::vector<PoseIndex> anchored;  ///< Places of the anchored poses, which have no columns.
  FactorSelection<Dim> priors;
};

/// Moves the partial map as a whole into the World's frame: by its fixed poses and priors, if these determine an alignment;
/// with its first pose at `origin`, if none of them has a position.
template <int Dim>
void place_in_world(const SubmapGraph<Dim>& graph, const Pose<Dim>& origin, PartialMap<Dim>& partial);

/// The gauge of a partial map: its fixed poses and priors or, if it has neither, its first pose.
template <int Dim>
Gauge<Dim> gauge_of(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& partial);

/// Sets fixed poses to their values.
template <int Dim>
void place_fixed_poses(const SubmapGraph<Dim>& graph, PartialMap<Dim>& partial);

}  // namespace mapjoin
