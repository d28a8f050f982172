// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The tree along which "relative" is meant: every pose and feature of the joined state has a pose as its parent.

#include <mapjoin/join/joining_system.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// Which observation relates a child to its parent: one is its base, the other its target number `target`.
struct TreeObservation {
  std::size_t factor = 0;  ///< Of the joining system.
  std::size_t target = 0;
  bool child_is_base = false;
};

/// Parent and child, a pose or a feature, are places of the joined state.
template <typename Child>
struct TreeEdge {
  Child child = 0;
  PoseIndex parent = kWorld;
  std::optional<TreeObservation> observation;  ///< None where only the World is there as a parent.
};

/// A forest whose roots are the poses that are anchored, and the World.
struct SpanningTree {
  std::vector<TreeEdge<PoseIndex>> poses;  ///< All but the held ones, parents before their children.
  Table<FeatureIndex, TreeEdge<FeatureIndex>> features;
};

/// Poses hang along local maps and odometry where they can: for one robot a chain. Closures and priors come after these. Where
/// only features tie two sessions, the parent of the second is the World. That of a feature is the pose that saw it first.
template <int Dim>
SpanningTree spanning_tree(const JoiningSystem<Dim>& system);

/// A target in the frame of its base, as it was measured, and the information of its rows alone.
template <typename Target, int Dof>
struct Measured {
  Target value;
  Matrix<Dof> information;
};

/// What was measured of the pose, or feature, by which an edge hangs.
template <int Dim>
Measured<Pose<Dim>, kPoseDof<Dim>> measured_pose(const JoiningSystem<Dim>& system, const TreeObservation& observation);
template <int Dim>
Measured<Point<Dim>, Dim> measured_point(const JoiningSystem<Dim>& system, const TreeObservation& observation);

}  // namespace mapjoin
