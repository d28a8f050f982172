// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/relative_state.hpp>
#include <mapjoin/model/linearise.hpp>
#include <mapjoin/solve/sparse_solver.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

/// The information about its child that the observation of an edge gives, with the parent held.
template <int Dim>
PoseMatrix<Dim> information_of_child(const JoiningSystem<Dim>& system, const TreeEdge<PoseIndex>& edge) {
  const auto [measured, W] = measured_pose(system, *edge.observation);
  const bool child_is_base = edge.observation->child_is_base;
  const Values<Dim>& state = system.estimate();
  const Pose<Dim> child = state.pose(edge.child);
  const Pose<Dim> parent = state.pose(edge.parent);
  const auto linear = child_is_base ? linearise<Dim>(measured, child, parent) : linearise<Dim>(measured, parent, child);
  const auto& J = child_is_base ? linear.J_base : linear.J_target;
  return J.transpose() * W * J;
}

/// The inverse of M; nullopt if M is singular.
template <int Dof>
std::optional<Matrix<Dof>> inverse_of(const Matrix<Dof>& M) {
  const Eigen::LLT<Matrix<Dof>> llt(M);
  if (llt.info() != Eigen::Success) return std::nullopt;
  for (int i = 0; i < Dof; ++i) {
    if (has_lost_digits(llt.matrixLLT()(i, i), M(i, i))) return std::nullopt;
  }
  return llt.solve(Matrix<Dof>::Identity());
}

}  // namespace

template <int Dim>
RelativeState<Dim>::RelativeState(const JoiningSystem<Dim>& system) {
  const SpanningTree tree = spanning_tree(system);
  for (const auto& edge : tree.poses) poses_.push_back(make_link<kPoseDof<Dim>>(system, edge));
  for (const auto& edge : tree.features) {
    const PointMatrix<Dim> W = measured_point(system, edge.observation.value()).information;  // every feature has one
    features_.push_back({make_link<Dim>(system, edge), W, inverse_of<Dim>(W)});
  }
}

template <int Dim>
template <int Dof, typename Child>
auto RelativeState<Dim>::make_link(const JoiningSystem<Dim>& system, const TreeEdge<Child>& edge) const -> Link<Dof> {
  const Variable parent = system.variable(edge.parent);
  const Eigen::Index parent_begin = parent == kConstant ? kStill : system.equations().offset(parent);
  return {edge, system.equations().offset(system.variable(edge.child)), parent_begin, {}, {}, {}};
}

template <int Dim>
void RelativeState<Dim>::linearise(const JoiningSystem<Dim>& system) {
  const Values<Dim>& state = system.estimate();
  for (auto& link : poses_) {
    const Pose<Dim> parent = state.pose(link.edge.parent);
    compose(parent, between(parent, state.pose(link.edge.child)), &link.K);
  }
  for (auto& link : features_) {
    const Pose<Dim> parent = state.pose(link.edge.parent);
    transform(parent, transform_into(parent, state.features[link.edge.child]), &link.K);
  }
}

template <int Dim>
template <int Dof>
void RelativeState<Dim>::weigh_by(const Eigen::VectorXd& diagonal, Link<Dof>& link) {
  link.M = diagonal.template segment<Dof>(link.child).asDiagonal();
  link.M_inverse = inverse_of<Dof>(link.M).value_or(Matrix<Dof>::Zero());
}

template <int Dim>
void RelativeState<Dim>::weigh(const JoiningSystem<Dim>& system) {
  const Eigen::VectorXd diagonal = system.equations().diagonal();
  for (auto& link : poses_) {
    std::optional<PoseMatrix<Dim>> inverse;
    if (link.edge.observation) {
      link.M = information_of_child<Dim>(system, link.edge);
      inverse = inverse_of<kPoseDof<Dim>>(link.M);
    }
    if (!inverse) {
      weigh_by(diagonal, link);
    } else {
      link.M_inverse = *inverse;
    }
  }
  for (auto& link : features_) {
    if (!link.W_inverse) {
      weigh_by<Dim>(diagonal, link);
      continue;
    }
    const PointMatrix<Dim> R = system.estimate().pose(link.edge.parent).rotation.matrix();
    link.M = R * link.W * R.transpose();
    link.M_inverse = R * *link.W_inverse * R.transpose();
  }
}

template <int Dim>
template <int Dof>
Vector<Dof> RelativeState<Dim>::Link<Dof>::own(const Eigen::VectorXd& step) const {
  Vector<Dof> u = step.segment<Dof>(child);
  if (parent != kStill) u -= K * step.segment<kPoseDof<Dim>>(parent);
  return u;
}

template <int Dim>
template <typename F>
void RelativeState<Dim>::for_each_link(F&& f) const {
  for (const auto& link : poses_) f(link);
  for (const auto& link : features_) f(link);
}

template <int Dim>
double RelativeState<Dim>::inner(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  double sum = 0.0;
  for_each_link([&]<int Dof>(const Link<Dof>& link) {
    const Vector<Dof> u = link.own(a);
    sum += u.dot(link.M * (&a == &b ? u : link.own(b)));
  });
  return sum;
}

template <int Dim>
Eigen::VectorXd RelativeState<Dim>::descent(Eigen::VectorXd gradient) const {
  constexpr int kDof = kPoseDof<Dim>;
  const auto give_to_parent = [&]<int Dof>(const Link<Dof>& link) {
    if (link.parent == kStill) return;
    gradient.segment<kDof>(link.parent) += link.K.transpose() * gradient.segment<Dof>(link.child);
  };
  for (const auto& link : features_) give_to_parent(link);
  for (auto link = poses_.rbegin(); link != poses_.rend(); ++link) give_to_parent(*link);

  Eigen::VectorXd step = Eigen::VectorXd::Zero(gradient.size());
  for_each_link([&]<int Dof>(const Link<Dof>& link) {
    Vector<Dof> child = link.M_inverse * gradient.segment<Dof>(link.child);
    if (link.parent != kStill) child += link.K * step.segment<kDof>(link.parent);
    step.segment<Dof>(link.child) = child;
  });
  return step;
}

template <int Dim>
template <int Dof>
void RelativeState<Dim>::damp(JoiningSystem<Dim>& system, double damping, const Link<Dof>& link) const {
  const Matrix<Dof> M = damping * link.M;
  NormalEquations& equations = system.equations();
  if (!link.edge.observation) {
    equations.add_diagonal(system.variable(link.edge.child), M);
    return;
  }
  const TreeObservation& observation = *link.edge.observation;
  auto sink = equations.sink(observation.factor);
  const int target = 1 + static_cast<int>(observation.target);
  const int child = observation.child_is_base ? 0 : target;
  const int parent = observation.child_is_base ? target : 0;
  const Matrix<Dof, kPoseDof<Dim>> MK = M * link.K;
  sink.hessian(child, child, M);
  sink.hessian(parent, parent, link.K.transpose() * MK);
  if constexpr (Dof == kPoseDof<Dim>) {
    if (observation.child_is_base) return sink.hessian(child, parent, -MK);
  }
  sink.hessian(parent, child, -MK.transpose());
}

template <int Dim>
void RelativeState<Dim>::damp(JoiningSystem<Dim>& system, double damping) const {
  for_each_link([&](const auto& link) { damp(system, damping, link); });
}

template <int Dim>
Values<Dim> RelativeState<Dim>::retracted(const JoiningSystem<Dim>& system, const Eigen::VectorXd& step) const {
  const Values<Dim>& before = system.estimate();
  Values<Dim> after = before;
  for (const auto& link : poses_) {
    const Pose<Dim> parent = before.pose(link.edge.parent);
    PoseVector<Dim> own = link.own(step);
    own.template head<Dim>() = parent.rotation.matrix().transpose() * own.template head<Dim>();
    const Pose<Dim> relation = retract<Dim>(between(parent, before.pose(link.edge.child)), own);
    after.poses[link.edge.child] = compose(after.pose(link.edge.parent), relation);
  }
  for (const auto& link : features_) {
    const Pose<Dim> parent = before.pose(link.edge.parent);
    const Point<Dim> moved = before.features[link.edge.child] + link.own(step);
    after.features[link.edge.child] = transform(after.pose(link.edge.parent), transform_into(parent, moved));
  }
  return after;
}

template class RelativeState<2>;
template class RelativeState<3>;

}  // namespace mapjoin
