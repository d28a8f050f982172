// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The spanning tree of the relative state: every pose and feature of the joined state has a pose, or the World, as its parent.

#include <mapjoin/join/joining_system.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// The observation that relates a child to its parent: one is its base, the other its target number `target`.
struct TreeObservation {
  std::size_t factor = 0;  ///< Number of the factor in the joining system.
  std::size_t target = 0;
  bool child_is_base = false;
};

/// An edge of the spanning tree; parent and child, a pose or a feature, are places of the joined state.
template <typename Child>
struct TreeEdge {
  Child child = 0;
  PoseIndex parent = kWorld;
  std::optional<TreeObservation> observation;  ///< nullopt if the World is the parent for want of another.
};

/// The spanning forest of a joined state, whose roots are the anchored poses and the World.
struct SpanningTree {
  std::vector<TreeEdge<PoseIndex>> poses;  ///< All poses but the anchored ones, parents before their children.
  Table<FeatureIndex, TreeEdge<FeatureIndex>> features;
};

/// The spanning tree of a joined state. Poses hang along local maps and odometry if they can, for one robot a chain, then along
/// closures, then along priors. If only features tie two sessions, the parent of the second is the World. The parent of a
/// feature is the earliest pose that observed it.
template <int Dim>
SpanningTree spanning_tree(const JoiningSystem<Dim>& system);

/// A target as measured in the frame of its base, and the information of its rows alone.
template <typename Target, int Dof>
struct Measured {
  Target value;
  Matrix<Dof> information;
};

/// The measured pose, or point, of an edge's observation.
template <int Dim>
Measured<Pose<Dim>, kPoseDof<Dim>> measured_pose(const JoiningSystem<Dim>& system, const TreeObservation& observation);
template <int Dim>
Measured<Point<Dim>, Dim> measured_point(const JoiningSystem<Dim>& system, const TreeObservation& observation);

}  // namespace mapjoin
