// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The join with nothing marginalised: every pose and feature is a variable again. Refining minimises it, and covariances are
// blocks of its inverse.

#include <mapjoin/join/join.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <vector>

namespace mapjoin {

/// The observations of a submap graph as they were before local maps marginalised anything. `system` points into the others.
template <int Dim>
struct Restored {
  SubmapGraph<Dim> graph;
  PartialMap<Dim> joined_map;
  JoiningSystem<Dim> system;
};

/// Full SLAM over a log (paper's (8), (9)), where `segments` are those of the submap graph's maps, in their order; over local
/// maps of which nothing else is known, where there are none, the maps with their submap-local features. The estimate is
/// `state`, over all poses and features of the submap graph. What a map alone holds comes first in the elimination, then the
/// order of the join: marginalising again, now at the estimate. Without any maps nothing was marginalised, and it takes the
/// system of the join.
template <int Dim>
Restored<Dim> restored(const SubmapGraph<Dim>& graph, const std::vector<SegmentView<Dim>>& segments, Join<Dim>& join,
                       const Values<Dim>& state, Engine engine = Engine::kFronts);

}  // namespace mapjoin
