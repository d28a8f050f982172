// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The normal equations of an observation, whatever its storage: one `accumulate` over pairs of targets.
//
// An observation offers, per target t, its residual r_t and Jacobians M_t = ∂H_t/∂x_t and B_t = ∂H_t/∂x_b, and blocks W_st of
// its information. Slot 0 is the base, slot 1 + t the target t. The sink is given the blocks H_ij = J_iᵀ W J_j of slots i ≤ j
// and the right-hand sides g_i = J_iᵀ W r, so that H δ = g is the Gauss-Newton step.

#include <Eigen/Core>
#include <mapjoin/model/factor.hpp>
#include <mapjoin/model/linearise.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/values.hpp>
#include <vector>

namespace mapjoin {

/// A linearised observation of one target, its information scaled as its loss says.
template <int Dim, int Dof>
struct LinearObservation {
  LinearTarget<Dim, Dof> target;
  Matrix<Dof> W;
  double loss = 0.0;  ///< ρ(rᵀWr), with the information as it was.

  static constexpr int kDim = Dim;
  template <typename F>
  void for_each_target(F&& f) const {
    f(0, target);
  }
  template <int RowDof, int ColDof>
  const Matrix<Dof>& information(int, int) const {
    return W;
  }
  double cost(double) const { return loss; }
};

/// W scaled by the slope of the loss at the residual (iteratively reweighted least squares).
template <int Dim, int Dof>
LinearObservation<Dim, Dof> weighted(const LinearTarget<Dim, Dof>& target, const Matrix<Dof>& information, Loss loss) {
  const LossValue value = evaluate(loss, target.residual.dot(information * target.residual));
  return {target, value.weight * information, value.cost};
}

/// An observation at the values of its base and its target, a pose or a feature; `base` is the identity where it is the World.
template <template <int> typename Observation, int Dim, typename Target>
auto linearise(const Observation<Dim>& observation, const Pose<Dim>& base, const Target& target) {
  return weighted(linearise<Dim>(observation.measured, base, target), observation.information, observation.loss);
}

/// A linearised local map: its poses, then its features.
template <int Dim>
struct LinearMap {
  std::vector<LinearTarget<Dim, kPoseDof<Dim>>> poses;
  std::vector<LinearTarget<Dim, Dim>> features;
  const LocalMap<Dim>* map = nullptr;

  static constexpr int kDim = Dim;
  template <typename F>
  void for_each_target(F&& f) const {
    int t = 0;
    for (const auto& pose : poses) f(t++, pose);
    for (const auto& feature : features) f(t++, feature);
  }
  template <int RowDof, int ColDof>
  auto information(int s, int t) const {
    return map->information.template block<RowDof, ColDof>(map->row(static_cast<std::size_t>(s)),
                                                           map->row(static_cast<std::size_t>(t)));
  }
  double cost(double chi2) const { return evaluate(Loss::kQuadratic, chi2).cost; }
};

/// The map linearised at a base and at the values of its p-th pose and f-th feature, pose_at(p) and feature_at(f).
template <int Dim, typename PoseAt, typename FeatureAt>
LinearMap<Dim> linearise(const LocalMap<Dim>& map, const Pose<Dim>& base, PoseAt&& pose_at, FeatureAt&& feature_at) {
  LinearMap<Dim> linear;
  linear.map = &map;
  for (std::size_t p = 0; p < map.poses.size(); ++p) {
    linear.poses.push_back(linearise<Dim>(map.pose_estimates[p], base, pose_at(p)));
  }
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    linear.features.push_back(linearise<Dim>(map.feature_estimates[f], base, feature_at(f)));
  }
  return linear;
}

/// Gives `sink` the normal equations of `observation` and returns its cost ρ(rᵀWr).
template <typename Observation, typename Sink>
double accumulate(const Observation& observation, Sink&& sink) {
  constexpr int kDof = kPoseDof<Observation::kDim>;
  double chi2 = 0.0;
  Matrix<kDof> H_bb = Matrix<kDof>::Zero();
  Vector<kDof> g_b = Vector<kDof>::Zero();
  observation.for_each_target([&]<int DofT>(int t, const LinearTarget<Observation::kDim, DofT>& target_t) {
    Vector<DofT> Wr = Vector<DofT>::Zero();
    Matrix<kDof, DofT> BtW = Matrix<kDof, DofT>::Zero();
    observation.for_each_target([&]<int DofS>(int s, const LinearTarget<Observation::kDim, DofS>& target_s) {
      const Matrix<DofS, DofT> W_st = observation.template information<DofS, DofT>(s, t);
      Wr.noalias() += W_st.transpose() * target_s.residual;
      BtW.noalias() += target_s.J_base.transpose() * W_st;
      if (s <= t) sink.hessian(1 + s, 1 + t, target_s.J_target.transpose() * W_st * target_t.J_target);
    });
    chi2 += target_t.residual.dot(Wr);
    sink.hessian(0, 1 + t, BtW * target_t.J_target);
    sink.rhs(1 + t, target_t.J_target.transpose() * Wr);
    H_bb.noalias() += BtW * target_t.J_base;
    g_b.noalias() += target_t.J_base.transpose() * Wr;
  });
  sink.hessian(0, 0, H_bb);
  sink.rhs(0, g_b);
  return observation.cost(chi2);
}

}  // namespace mapjoin
