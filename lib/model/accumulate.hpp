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

/// A linearised observation of one target; W is scaled by the slope of its loss.
template <int Dim, int Dof>
struct LinearObservation {
  LinearTarget<Dim, Dof> target;
  Matrix<Dof> W;
  double loss = 0.0;  ///< ρ(rᵀWr), with W before scaling.

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

/// The observation with W scaled by the slope of the loss at the residual (iteratively reweighted least squares).
template <int Dim, int Dof>
LinearObservation<Dim, Dof> weighted(const LinearTarget<Dim, Dof>& target, const Matrix<Dof>& information, const Loss& loss) {
  const LossValue value = evaluate(loss, target.residual.dot(information * target.residual));
  return {target, value.weight * information, value.cost};
}

/// Chain rule over a lever: J_target, on input with respect to the lever's end, becomes that with respect to the target.
template <int Dim>
void chain_lever(const PoseFactor<Dim>& factor, const Pose<Dim>& target, LinearTarget<Dim, kPoseDof<Dim>>& linear) {
  if (factor.lever.isZero(0.0)) return;
  PointPoseMatrix<Dim> J_end_target;
  transform(target, factor.lever, &J_end_target);
  const PointMatrix<Dim> J_end = linear.J_target.template topLeftCorner<Dim, Dim>();
  linear.J_target.template topRows<Dim>() = J_end * J_end_target;
}
template <int Dim>
void chain_lever(const FeatureFactor<Dim>&, const Point<Dim>&, LinearTarget<Dim, Dim>&) {}

/// Linearises an observation at the values of its base and its target, a pose or a feature; `base` is the identity if it is the
/// World.
template <template <int> typename Observation, int Dim, typename Target>
auto linearise(const Observation<Dim>& observation, const Pose<Dim>& base, const Target& target) {
  auto linear = linearise<Dim>(observation.measured, base, measured_part(observation, target));
  chain_lever(observation, target, linear);
  return weighted(linear, observation.information, observation.loss);
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
  double cost(double chi2) const { return evaluate(Loss{}, chi2).cost; }
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

/// The rows of W r of target t; with_block(s, target s, W_st) is called for every target s.
template <int DofT, typename Observation, typename F>
Vector<DofT> weighted_residual(const Observation& observation, int t, F&& with_block) {
  Vector<DofT> Wr = Vector<DofT>::Zero();
  observation.for_each_target([&]<int DofS>(int s, const LinearTarget<Observation::kDim, DofS>& target_s) {
    const Matrix<DofS, DofT> W_st = observation.template information<DofS, DofT>(s, t);
    Wr.noalias() += W_st.transpose() * target_s.residual;
    with_block(s, target_s, W_st);
  });
  return Wr;
}

/// Gives `sink` the normal equations of `observation` and returns its cost ρ(rᵀWr).
template <typename Observation, typename Sink>
double accumulate(const Observation& observation, Sink&& sink) {
  constexpr int kDof = kPoseDof<Observation::kDim>;
  double chi2 = 0.0;
  Matrix<kDof> H_bb = Matrix<kDof>::Zero();
  Vector<kDof> g_b = Vector<kDof>::Zero();
  observation.for_each_target([&]<int DofT>(int t, const LinearTarget<Observation::kDim, DofT>& target_t) {
    Matrix<kDof, DofT> BtW = Matrix<kDof, DofT>::Zero();
    const Vector<DofT> Wr = weighted_residual<DofT>(observation, t, [&](int s, const auto& target_s, const auto& W_st) {
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

/// The second derivatives of u · r, with r the rotation residual of a pose in space, with respect to rotations of the target
/// (tt), of base and target (bt), and of the base (bb).
struct RotationCurvature {
  Matrix<3> H_tt;
  Matrix<3> H_bt;
  Matrix<3> H_bb;
};

/// The curvature of r = Log(Exp(-w_t) Exp(M w_b) Exp(r)), M = R_tᵀ R_b; two rotations a, b compose to a + b + ½ a × b.
inline RotationCurvature rotation_curvature(const LinearTarget<3, kPoseDof<3>>& target, const Vector<3>& u) {
  const Matrix<3> J = target.J_target.bottomRightCorner<3, 3>();
  const Matrix<3> M = -J.inverse() * target.J_base.bottomRightCorner<3, 3>();
  const Matrix<3> Q = log_curvature(target.residual.tail<3>(), u);
  return {Q, -M.transpose() * (Q + 0.5 * skew(Vector<3>(J.transpose() * u))), M.transpose() * Q * M};
}

/// Gives `sink` the difference of full Newton's H from Gauss-Newton's, -Σ (Wr)ᵀ ∂²H_t, without the curvature of levers, which
/// are short beside a map.
template <typename Observation, typename Sink>
void accumulate_curvature(const Observation& observation, Sink&& sink) {
  constexpr int kDim = Observation::kDim;
  constexpr int kDof = kPoseDof<kDim>;
  constexpr int kRot = kRotationDof<kDim>;
  Matrix<kDof> H_bb = Matrix<kDof>::Zero();
  observation.for_each_target([&]<int DofT>(int t, const LinearTarget<kDim, DofT>& target_t) {
    const Vector<DofT> Wr = weighted_residual<DofT>(observation, t, [](int, const auto&, const auto&) {});
    // Positions: a rotation w of the base changes rows J of the Jacobians to J - w × J, which gives the rows -(Wr) × J of w.
    const Matrix<kRot, kDim> minus_Wr_cross = -skew(Vector<kDim>(Wr.template head<kDim>()));
    Matrix<kDof, DofT> H_bt = Matrix<kDof, DofT>::Zero();
    H_bt.template bottomRows<kRot>() = minus_Wr_cross * target_t.J_target.template topRows<kDim>();
    Matrix<kRot, kDof> H_wb = minus_Wr_cross * target_t.J_base.template topRows<kDim>();
    if constexpr (kDim == 3 && DofT == kDof) {
      const RotationCurvature rotation = rotation_curvature(target_t, Wr.template tail<3>());
      H_bt.template bottomRightCorner<3, 3>() += rotation.H_bt;
      H_wb.template rightCols<3>() += rotation.H_bb;
      Matrix<kDof> H_tt = Matrix<kDof>::Zero();
      H_tt.template bottomRightCorner<3, 3>() = rotation.H_tt;
      sink.hessian(1 + t, 1 + t, H_tt);
    }
    sink.hessian(0, 1 + t, H_bt);
    H_bb.template bottomRows<kRot>() += H_wb;
  });
  H_bb.template bottomRightCorner<kRot, kRot>() *= 0.5;
  sink.hessian(0, 0, H_bb + H_bb.transpose());
}

}  // namespace mapjoin
