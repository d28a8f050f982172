// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The join with nothing marginalised: every pose and feature is a variable again. Refining minimises its chi2, and covariances
// are blocks of the inverse of its information.

#include <mapjoin/join/join.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <vector>

namespace mapjoin {

/// The observations of a submap graph as they were before local maps marginalised anything. `system` points into the other
/// members.
template <int Dim>
struct Restored {
  SubmapGraph<Dim> graph;
  PartialMap<Dim> joined_map;
  JoiningSystem<Dim> system;
};

/// The join before marginalisation: full SLAM over a log (paper's (8), (9)) if `segments`, those of the submap graph's maps in
/// their order, are given; otherwise the local maps with their submap-local features. The estimate is `state`, over all poses
/// and features of the submap graph. Variables of one map alone are eliminated first, then the others in the order of the join:
/// this marginalises again, now at the estimate. Without any maps nothing was marginalised, and the system of `join` is moved
/// out of it.
template <int Dim>
Restored<Dim> restored(const SubmapGraph<Dim>& graph, const std::vector<SegmentView<Dim>>& segments, Join<Dim>& join,
                       const Values<Dim>& state, Engine engine = Engine::kFronts);

}  // namespace mapjoin
