// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Lines of states, straight in absolute or in relative coordinates.
//
// Headings in the plane are real numbers here, not angles: a line must not jump where one of them passes ±π. Which of the many
// numbers of a heading is meant is said by a reference state, the best estimate.

#include <Eigen/Core>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/spanning_tree.hpp>
#include <mapjoin/model/values.hpp>

namespace mapjoin {

/// The state with every heading within half a turn of the reference's; in space as it is.
template <int Dim>
Values<Dim> unwrapped_near(Values<Dim> state, const Values<Dim>& reference);

/// λX + (1-λ)Y in absolute coordinates: positions and headings straight, in space rotations along the geodesic.
template <int Dim>
Values<Dim> on_line(const Values<Dim>& X, const Values<Dim>& Y, double lambda);

/// Of a state, how the relations along the spanning tree differ from what was measured of them (paper's (22), (33) less a
/// constant): translation in the frame of the base (m), then rotation, in space as the rotation vector about the measured one.
/// In these coordinates what the tree's observations say is linear, in space, too: (24), (25).
template <int Dim>
class RelativeCoordinates {
 public:
  /// Poses that the system holds stay where they are in `reference`.
  RelativeCoordinates(const JoiningSystem<Dim>& system, const Values<Dim>& reference);

  const SpanningTree& tree() const { return tree_; }
  Eigen::Index size() const { return feature_entry(indices(tree_.features).last); }
  /// Where the entries of an edge begin: of a pose's by its place in the tree's list, of a feature's by the feature.
  Eigen::Index pose_entry(std::size_t edge) const { return static_cast<Eigen::Index>(edge) * kPoseDof<Dim>; }
  Eigen::Index feature_entry(FeatureIndex child) const { return pose_entry(tree_.poses.size()) + child.value * Dim; }

  Eigen::VectorXd of(const Values<Dim>& state) const;
  /// The state that has these coordinates.
  Values<Dim> composed(const Eigen::VectorXd& coordinates) const;

 private:
  Pose<Dim> relation(const TreeEdge<PoseIndex>& edge, const Values<Dim>& state) const;

  SpanningTree tree_;
  Values<Dim> anchored_;          // of which only what is anchored counts
  std::vector<Pose<Dim>> poses_;  // the relations as measured, per edge
  Table<FeatureIndex, Point<Dim>> features_;
};

}  // namespace mapjoin
