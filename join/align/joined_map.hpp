// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A whole submap graph as one partial map in the World, from which the last join starts.

#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/schedule.hpp>

namespace mapjoin {

/// All poses, features, maps and observations of a submap graph, in its order, as one partial map; its state is zero.
template <int Dim>
PartialMap<Dim> joined_map_of(const SubmapGraph<Dim>& graph);

/// The state of `joined_map` from the partial maps of the join, several if only the World ties them together. A partial map
/// that the World does not tie has its first pose at `origin`.
template <int Dim>
Values<Dim> composed_state(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& joined_map, const Pose<Dim>& origin,
                           JoinedPartialMaps<Dim> joined);

}  // namespace mapjoin
