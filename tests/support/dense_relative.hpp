// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The relative joined state, dense: every Jacobian of the paper's (26)-(29) and (35) along the paths of the tree.

#include <map>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/spanning_tree.hpp>
#include <mapjoin/model/linearise.hpp>
#include <utility>
#include <vector>

namespace mapjoin::testing {

/// The dense J_rel, W and r of all observations of a joining system, which must just have been linearised at its estimate. A
/// relation has the columns that its child has in the absolute state.
template <int Dim>
class DenseRelative {
 public:
  static constexpr int kDof = kPoseDof<Dim>;

  explicit DenseRelative(const JoiningSystem<Dim>& system)
      : system_(system), state_(system.estimate()), tree_(spanning_tree(system)) {
    const Eigen::Index n = system.equations().size();
    T = Eigen::MatrixXd::Zero(n, n);
    for (const auto& edge : tree_.poses) compose_pose(edge);
    for (const auto& edge : tree_.features) compose_feature(edge);
    for (const auto& o : system.pose_factors()) {
      add_rows(linearise<Dim>(o.observation->measured, state_.pose(o.base), state_.pose(o.target)), o.base, entry(o.target),
               o.observation->information);
    }
    for (const auto& o : system.feature_factors()) {
      add_rows(linearise<Dim>(o.observation->measured, state_.pose(o.base), state_.features[o.target]), o.base, entry(o.target),
               o.observation->information);
    }
    for (const auto& map : system.maps()) add_map(map);
    H = J.transpose() * W * J;
    g = J.transpose() * W * r;
    D = Eigen::MatrixXd::Zero(n, n);
    for (const auto& edge : tree_.poses) weigh(edge, entry(edge.child), kDof);
    for (const auto& edge : tree_.features) weigh(edge, entry(edge.child), Dim);
  }

  /// The state whose relations are those of the estimate moved by `step`.
  Values<Dim> moved(const Eigen::VectorXd& step) const {
    Values<Dim> state = state_;
    for (const auto& edge : tree_.poses) {
      const Pose<Dim> relation = between(state_.pose(edge.parent), state_.pose(edge.child));
      const PoseVector<Dim> delta = step.segment<kDof>(entry(edge.child));
      state.poses[edge.child] = compose(state.pose(edge.parent), retract<Dim>(relation, delta));
    }
    for (const auto& edge : tree_.features) {
      const Point<Dim> relation = transform_into(state_.pose(edge.parent), state_.features[edge.child]);
      const Point<Dim> delta = step.segment<Dim>(entry(edge.child));
      state.features[edge.child] = transform<Dim>(state.pose(edge.parent), relation + delta);
    }
    return state;
  }

  Eigen::MatrixXd T;  ///< The Jacobian ∂x_abs/∂x_rel.
  Eigen::MatrixXd J;  ///< The Jacobian J_rel of all observations.
  Eigen::MatrixXd W;
  Eigen::VectorXd r;
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  Eigen::MatrixXd D;  ///< The information of each edge's observation on its relation.

 private:
  Eigen::Index entry(PoseIndex place) const {
    const Variable variable = system_.variable(place);
    return variable == kConstant ? -1 : system_.equations().offset(variable);
  }
  Eigen::Index entry(FeatureIndex place) const { return system_.equations().offset(system_.variable(place)); }

  void compose_pose(const TreeEdge<PoseIndex>& edge) {
    PoseMatrix<Dim> J_parent, J_relation;
    const Pose<Dim> parent = state_.pose(edge.parent);
    compose(parent, between(parent, state_.pose(edge.child)), &J_parent, &J_relation);
    hang<kDof>(entry(edge.child), entry(edge.parent), J_parent, J_relation);
  }
  void compose_feature(const TreeEdge<FeatureIndex>& edge) {
    PointPoseMatrix<Dim> J_parent;
    PointMatrix<Dim> J_relation;
    const Pose<Dim> parent = state_.pose(edge.parent);
    transform(parent, transform_into(parent, state_.features[edge.child]), &J_parent, &J_relation);
    hang<Dim>(entry(edge.child), entry(edge.parent), J_parent, J_relation);
  }
  template <int Dof, typename JParent, typename JRelation>
  void hang(Eigen::Index child, Eigen::Index parent, const JParent& J_parent, const JRelation& J_relation) {
    if (parent >= 0) T.middleRows<Dof>(child) = J_parent * T.middleRows<kDof>(parent).eval();
    T.block<Dof, Dof>(child, child) += J_relation;
  }

  void grow(Eigen::Index rows) {
    const Eigen::Index before = r.size();
    J.conservativeResize(before + rows, T.cols());
    r.conservativeResize(before + rows);
    W.conservativeResize(before + rows, before + rows);
    W.rightCols(rows).setZero();
    W.bottomRows(rows).setZero();
    J.bottomRows(rows).setZero();
  }
  template <int Dof>
  void set_rows(Eigen::Index row, const LinearTarget<Dim, Dof>& linear, PoseIndex base, Eigen::Index target) {
    r.segment<Dof>(row) = linear.residual;
    if (target >= 0) J.middleRows<Dof>(row) += linear.J_target * T.middleRows<Dof>(target);
    if (entry(base) >= 0) J.middleRows<Dof>(row) += linear.J_base * T.middleRows<kDof>(entry(base));
  }
  template <int Dof>
  void add_rows(const LinearTarget<Dim, Dof>& linear, PoseIndex base, Eigen::Index target, const Matrix<Dof>& information) {
    const Eigen::Index row = r.size();
    grow(Dof);
    set_rows(row, linear, base, target);
    W.bottomRightCorner<Dof, Dof>() = information;
    first_row_.push_back(row);
  }
  void add_map(const typename JoiningSystem<Dim>::PlacedMap& placed) {
    const LocalMap<Dim>& map = *placed.map;
    Eigen::Index row = r.size();
    first_row_.push_back(row);
    grow(map.information.rows());
    W.bottomRightCorner(map.information.rows(), map.information.cols()) = map.information;
    const Pose<Dim> base = state_.pose(placed.base);
    for (std::size_t p = 0; p < map.poses.size(); ++p, row += kDof) {
      const auto linear = linearise<Dim>(map.pose_estimates[p], base, state_.pose(placed.poses[p]));
      set_rows(row, linear, placed.base, entry(placed.poses[p]));
    }
    first_feature_row_[first_row_.size() - 1] = {row, map.poses.size()};
    for (std::size_t f = 0; f < map.features.size(); ++f, row += Dim) {
      const auto linear = linearise<Dim>(map.feature_estimates[f], base, state_.features[placed.features[f]]);
      set_rows(row, linear, placed.base, entry(placed.features[f]));
    }
  }
  template <typename Child>
  void weigh(const TreeEdge<Child>& edge, Eigen::Index child, int dof) {
    if (!edge.observation) {  // no observation of this edge alone: H of the child, as RelativeState takes it
      D.block(child, child, dof, dof) = system_.equations().diagonal().segment(child, dof).asDiagonal();
      return;
    }
    const TreeObservation& o = *edge.observation;
    Eigen::Index row = first_row_[o.factor];
    if (const auto map = first_feature_row_.find(o.factor); map != first_feature_row_.end()) {
      const auto [feature_row, poses] = map->second;
      const auto target = static_cast<Eigen::Index>(o.target);
      row = dof == kDof ? row + target * kDof : feature_row + (target - static_cast<Eigen::Index>(poses)) * Dim;
    }
    const Eigen::MatrixXd J_edge = J.block(row, child, dof, dof);
    D.block(child, child, dof, dof) = J_edge.transpose() * W.block(row, row, dof, dof) * J_edge;
  }

  const JoiningSystem<Dim>& system_;
  const Values<Dim>& state_;
  SpanningTree tree_;
  std::vector<Eigen::Index> first_row_;  // of each factor
  /// The first row of the features of a map, by its factor, and the number of its poses.
  std::map<std::size_t, std::pair<Eigen::Index, std::size_t>> first_feature_row_;
};

}  // namespace mapjoin::testing
