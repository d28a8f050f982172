// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The relative joined state (paper's (22), (33)) as coordinates of the step.
//
// With T = ∂x_abs/∂x_rel, square and invertible along a spanning tree, the Gauss-Newton step in relative coordinates is
// T δ_rel = δ_abs: the sparse absolute system is solved, and its step converted along the tree. T is never formed. A child's
// step is
//
//   δ_child = K δ_parent + u,   K = ∂(parent ⊕ relation)/∂parent,
//
// the step that its parent carries it along, and its own. Steps are measured by Σ uᵀMu over the edges of the tree, M being the
// information of the edge's observation: the metric D of the relative state, in which its trust region damps. T⁻ᵀDT⁻¹ adds no
// fill, as edges are observations.

#include <Eigen/Core>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/spanning_tree.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// The StepMetric of the relative state. Steps are given in the absolute coordinates of the joining system.
template <int Dim>
class RelativeState {
 public:
  /// The observations of `system` must not change while this is used.
  explicit RelativeState(const JoiningSystem<Dim>& system);

  /// Computes K at the estimate of the system.
  void linearise(const JoiningSystem<Dim>& system);
  /// Computes M at the estimate, after linearise(); the normal equations must be those of the observations, undamped.
  void weigh(const JoiningSystem<Dim>& system);

  double inner(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  /// T D⁻¹ Tᵀ g: steepest descent in relative coordinates. O(n).
  Eigen::VectorXd descent(Eigen::VectorXd gradient) const;
  /// Adds damping · T⁻ᵀ D T⁻¹ to the normal equations: the rows of the tree, weighted more.
  void damp(JoiningSystem<Dim>& system, double damping) const;

  /// The estimate of the system after a step: the step is converted to relations, and the moved relations are composed from the
  /// roots.
  Values<Dim> retracted(const JoiningSystem<Dim>& system, const Eigen::VectorXd& step) const;

 private:
  /// An edge of the tree whose child has `Dof` degrees of freedom.
  template <int Dof>
  struct Link {
    TreeEdge<std::conditional_t<Dof == Dim, FeatureIndex, PoseIndex>> edge;
    Eigen::Index child;   // first entry of the child's step
    Eigen::Index parent;  // first entry of the parent's step; kStill if the parent is anchored
    Matrix<Dof, kPoseDof<Dim>> K;
    Matrix<Dof> M;
    Matrix<Dof> M_inverse;

    Vector<Dof> own(const Eigen::VectorXd& step) const;
  };
  /// An edge to a feature. Its observation is linear in the relation, so its information W in the frame of the parent is
  /// constant.
  struct FeatureLink : Link<Dim> {
    PointMatrix<Dim> W;
    std::optional<PointMatrix<Dim>> W_inverse;  // nullopt if W is singular
  };
  static constexpr Eigen::Index kStill = -1;

  template <int Dof, typename Child>
  Link<Dof> make_link(const JoiningSystem<Dim>& system, const TreeEdge<Child>& edge) const;
  /// Sets M of an edge that does not determine its child to the child's entries of the information's `diagonal`.
  template <int Dof>
  static void weigh_by(const Eigen::VectorXd& diagonal, Link<Dof>& link);
  template <int Dof>
  void damp(JoiningSystem<Dim>& system, double damping, const Link<Dof>& link) const;
  template <typename F>
  void for_each_link(F&& f) const;

  std::vector<Link<kPoseDof<Dim>>> poses_;  // parents before their children
  std::vector<FeatureLink> features_;
};

}  // namespace mapjoin
