// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the World says of a partial map: where it stands, and what holds it still.

#include <mapjoin/join/align/partial_map.hpp>
#include <vector>

namespace mapjoin {

/// What holds a partial map still.
template <int Dim>
struct Gauge {
  std::vector<PoseIndex> anchored;  ///< Places of poses that have no columns.
  FactorSelection<Dim> priors;
};

/// Moves the partial map as a whole into the World's frame: by its fixed poses and priors or, without any position among them,
/// its first pose to `origin`.
template <int Dim>
void place_in_world(const SubmapGraph<Dim>& graph, const Pose<Dim>& origin, PartialMap<Dim>& partial);

/// What holds the partial map: fixed poses and priors, else its first pose.
template <int Dim>
Gauge<Dim> gauge_of(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& partial);

/// Puts fixed poses at their values.
template <int Dim>
void place_fixed_poses(const SubmapGraph<Dim>& graph, PartialMap<Dim>& partial);

}  // namespace mapjoin
