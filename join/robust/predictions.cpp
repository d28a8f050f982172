// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {

template <int Dim>
Predictions<Dim>::Predictions(const JoiningSystem<Dim>& system, const Marginals& marginals, std::size_t most)
    : system_(system), covariances_(system.estimate().poses.size(), PoseMatrix<Dim>::Zero()) {
  constexpr int kDof = kPoseDof<Dim>;
  const NormalEquations& equations = system.equations();
  parallel_for(covariances_.size(), [&](std::size_t p) {
    const Variable v = system.variable(PoseIndex(p));
    if (v != kConstant) covariances_[PoseIndex(p)] = marginals[v];
  });
  const std::size_t count = std::min(most, covariances_.size());
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(equations.size(), static_cast<Eigen::Index>(count) * kDof);
  for (std::size_t b = 0; b < count; ++b) {
    places_.emplace_back((2 * b + 1) * covariances_.size() / (2 * count));
    const Variable v = system.variable(places_.back());
    if (v == kConstant) continue;
    unit.block<kDof, kDof>(equations.offset(v), static_cast<Eigen::Index>(b) * kDof).setIdentity();
  }
  columns_ = equations.solve_columns(unit);
}

/// The covariance of a pose with a landing place.
template <int Dim>
PoseMatrix<Dim> Predictions<Dim>::columns(PoseIndex pose, std::size_t place) const {
  constexpr int kDof = kPoseDof<Dim>;
  const Variable v = system_.variable(pose);
  if (v == kConstant) return PoseMatrix<Dim>::Zero();
  return columns_.block<kDof, kDof>(system_.equations().offset(v), static_cast<Eigen::Index>(place) * kDof);
}

template <int Dim>
UncertainPose<Dim> Predictions<Dim>::mismatch(const PoseFactor<Dim>& closure) const {
  const Values<Dim>& values = system_.estimate();
  const auto linear = linearise<Dim>(closure.measured, values.poses[closure.base], values.poses[closure.target]);
  const PoseMatrix<Dim>& P_base = covariances_[closure.base];
  const PoseMatrix<Dim>& P_target = covariances_[closure.target];
  const PoseMatrix<Dim> own = covariance_of(closure.information) + linear.J_base * P_base * linear.J_base.transpose() +
                              linear.J_target * P_target * linear.J_target.transpose();
  PoseMatrix<Dim> least = own;
  for (const PoseIndex end : {closure.base, closure.target}) {
    const std::size_t b = end.position() * places_.size() / covariances_.size();
    const Eigen::LLT<PoseMatrix<Dim>> P_place(covariances_[places_[b]]);
    if (P_place.info() != Eigen::Success) continue;  // the pose that holds the map
    const PoseMatrix<Dim> across = linear.J_base * columns(closure.base, b) *
                                   P_place.solve(columns(closure.target, b).transpose()) * linear.J_target.transpose();
    const PoseMatrix<Dim> S = own + across + across.transpose();
    if (S.trace() < least.trace()) least = S;
  }
  return {retract(Pose<Dim>{}, linear.residual), least};
}

template class Predictions<2>;
template class Predictions<3>;

}  // namespace mapjoin
