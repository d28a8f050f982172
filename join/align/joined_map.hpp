// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A whole submap graph as one partial map in the World: what the last join starts from.

#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/schedule.hpp>

namespace mapjoin {

/// All poses, features, maps and observations of a submap graph, in its order, as one partial map; its state is zero.
template <int Dim>
PartialMap<Dim> joined_map_of(const SubmapGraph<Dim>& graph);

/// The state of that partial map by those that it was joined from: the tied ones, and those that only the World ties together.
/// Where the World says nothing of a partial map, its first pose is at `origin`.
template <int Dim>
Values<Dim> composed_state(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& joined_map, const Pose<Dim>& origin,
                           JoinedPartialMaps<Dim> joined);

}  // namespace mapjoin
