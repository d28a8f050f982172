// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Residual and Jacobians of one target seen from one base: the one observation model (paper's (10), (11), (31)).

#include <mapjoin/geometry/pose.hpp>

namespace mapjoin {

/// The residual X̂_t - H_t(X) of one target of `Dof` degrees of freedom, and H_t's Jacobians with respect to the steps
/// of the target and of the base.
template <int Dim, int Dof>
struct LinearTarget {
  Vector<Dof> residual;
  Matrix<Dof> J_target;
  Matrix<Dof, kPoseDof<Dim>> J_base;
};

/// The residual X̂ - H(X) of a point target: p̂ - R_bᵀ(p - t_b), in the frame of the base.
template <int Dim>
Point<Dim> residual(const Point<Dim>& measured, const Pose<Dim>& base, const Point<Dim>& target) {
  return measured - transform_into(base, target);
}

/// The residual X̂ - H(X) of a pose target: translation as for a point, rotation Log((R_bᵀ R_t)ᵀ R̂).
template <int Dim>
PoseVector<Dim> residual(const Pose<Dim>& measured, const Pose<Dim>& base, const Pose<Dim>& target) {
  return local(between(base, target), measured);
}

template <int Dim>
LinearTarget<Dim, Dim> linearise(const Point<Dim>& measured, const Pose<Dim>& base, const Point<Dim>& target) {
  LinearTarget<Dim, Dim> linear;
  linear.residual = measured - transform_into(base, target, &linear.J_base, &linear.J_target);
  return linear;
}

template <int Dim>
LinearTarget<Dim, kPoseDof<Dim>> linearise(const Pose<Dim>& measured, const Pose<Dim>& base, const Pose<Dim>& target) {
  constexpr int kRot = kRotationDof<Dim>;
  LinearTarget<Dim, kPoseDof<Dim>> linear;
  linear.residual = local(between(base, target, &linear.J_base, &linear.J_target), measured);
  // The rotation rows are Log(R̂ᵀ R_bᵀ R_t) = -r_φ: a step δ on the right of R_bᵀ R_t moves it by Jr⁻¹(-r_φ) δ.
  const RotationVector<Dim> r_rotation = linear.residual.template tail<kRot>();
  const RotationJacobian<Dim> J = right_jacobian_inverse(RotationVector<Dim>(-r_rotation));
  linear.J_base.template bottomRightCorner<kRot, kRot>() = J * linear.J_base.template bottomRightCorner<kRot, kRot>();
  linear.J_target.template bottomRightCorner<kRot, kRot>() = J;
  return linear;
}

}  // namespace mapjoin
