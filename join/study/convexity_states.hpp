// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Lines of states, straight in absolute or in relative coordinates.
//
// Headings in the plane are real numbers here, not angles: a line must not jump where one of them passes ±π. A reference state,
// the best estimate, selects one of the many numbers of a heading.

#include <Eigen/Core>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/spanning_tree.hpp>
#include <mapjoin/model/values.hpp>

namespace mapjoin {

/// The state with every heading within half a turn of the reference's; unchanged in space.
template <int Dim>
Values<Dim> unwrapped_near(Values<Dim> state, const Values<Dim>& reference);

/// λX + (1-λ)Y in absolute coordinates: positions and headings straight, in space rotations along the geodesic.
template <int Dim>
Values<Dim> on_line(const Values<Dim>& X, const Values<Dim>& Y, double lambda);

/// The relative coordinates of a state: the differences of the relations along the spanning tree from their measured values
/// (paper's (22), (33) less a constant), translation in the frame of the base (m), then rotation (rad), in space as the
/// rotation vector about the measured one. The tree's observations are linear in them, in space, too: (24), (25).
template <int Dim>
class RelativeCoordinates {
 public:
  /// Anchored poses of the system stay where they are in `reference`.
  RelativeCoordinates(const JoiningSystem<Dim>& system, const Values<Dim>& reference);

  const SpanningTree& tree() const { return tree_; }
  Eigen::Index size() const { return feature_entry(indices(tree_.features).last); }
  /// The first entry of an edge: of a pose's by its place in the tree's list, of a feature's by the feature.
  Eigen::Index pose_entry(std::size_t edge) const { return static_cast<Eigen::Index>(edge) * kPoseDof<Dim>; }
  Eigen::Index feature_entry(FeatureIndex child) const { return pose_entry(tree_.poses.size()) + child.value * Dim; }

  Eigen::VectorXd of(const Values<Dim>& state) const;
  /// The state that has these coordinates.
  Values<Dim> composed(const Eigen::VectorXd& coordinates) const;

 private:
  Pose<Dim> relation(const TreeEdge<PoseIndex>& edge, const Values<Dim>& state) const;

  SpanningTree tree_;
  Values<Dim> anchored_;          // only its anchored poses count
  std::vector<Pose<Dim>> poses_;  // the relations as measured, per edge
  Table<FeatureIndex, Point<Dim>> features_;
};

}  // namespace mapjoin
