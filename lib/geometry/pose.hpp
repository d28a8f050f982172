// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Poses and their operations: retract and local; compose, between, inverse and transform with their Jacobians.
//
// A step δ of a pose is (translation, rotation): the translation is added in the parent frame, the rotation composed on the
// right, t ← t + δ_t, R ← R Exp(δ_φ). In 2D this is the paper's (x, y, φ). A Jacobian is written only if asked for.

#include <cmath>
#include <mapjoin/geometry/rotation.hpp>

namespace mapjoin {

/// A pose: where a frame stands in its parent frame, p_parent = R p + t.
template <int Dim>
struct Pose {
  Point<Dim> translation = Point<Dim>::Zero();
  Rotation<Dim> rotation;

  /// True if the numbers of the translation and of the rotation matrix are equal.
  bool operator==(const Pose& other) const {
    return translation == other.translation && rotation.matrix() == other.rotation.matrix();
  }
};

/// A step of a pose: translation (m), then rotation (rad).
template <int Dim>
using PoseVector = Vector<kPoseDof<Dim>>;
template <int Dim>
using PoseMatrix = Matrix<kPoseDof<Dim>>;
template <int Dim>
using PointMatrix = Matrix<Dim>;
/// The Jacobian ∂point/∂pose.
template <int Dim>
using PointPoseMatrix = Matrix<Dim, kPoseDof<Dim>>;

/// True if the numbers of a value are valid: all finite, a quaternion of unit length.
template <int Dim>
bool is_valid(const Point<Dim>& point) {
  return point.allFinite();
}
inline bool is_valid(const Rotation<2>& rotation) {
  return std::isfinite(rotation.angle());
}
inline bool is_valid(const Rotation<3>& rotation) {
  return std::abs(rotation.quaternion().norm() - 1.0) < 1e-9;
}
template <int Dim>
bool is_valid(const Pose<Dim>& pose) {
  return pose.translation.allFinite() && is_valid(pose.rotation);
}

/// The pose moved by the step `delta`.
template <int Dim>
Pose<Dim> retract(const Pose<Dim>& pose, const PoseVector<Dim>& delta) {
  return {pose.translation + delta.template head<Dim>(),
          pose.rotation * Rotation<Dim>::exp(delta.template tail<kRotationDof<Dim>>())};
}

/// The step from `from` to `to`: retract(from, local(from, to)) is `to`. Its rotation part has length at most π.
template <int Dim>
PoseVector<Dim> local(const Pose<Dim>& from, const Pose<Dim>& to) {
  PoseVector<Dim> delta;
  delta << to.translation - from.translation, (from.rotation.inverse() * to.rotation).log();
  return delta;
}

/// The pose of c in frame a, from b in a and c in b (paper's (2), (4)).
template <int Dim>
Pose<Dim> compose(const Pose<Dim>& a_b, const Pose<Dim>& b_c, PoseMatrix<Dim>* J_out_ab = nullptr,
                  PoseMatrix<Dim>* J_out_bc = nullptr) {
  constexpr int kRot = kRotationDof<Dim>;
  const PointMatrix<Dim> R = a_b.rotation.matrix();
  if (J_out_ab) {
    J_out_ab->setIdentity();
    J_out_ab->template topRightCorner<Dim, kRot>() = R * J_turned_rotation(b_c.translation);
    J_out_ab->template bottomRightCorner<kRot, kRot>() = J_after_before(b_c.rotation);
  }
  if (J_out_bc) {
    J_out_bc->setIdentity();
    J_out_bc->template topLeftCorner<Dim, Dim>() = R;
  }
  return {a_b.translation + R * b_c.translation, a_b.rotation * b_c.rotation};
}

/// The pose of the parent in the frame of `pose`.
template <int Dim>
Pose<Dim> inverse(const Pose<Dim>& pose, PoseMatrix<Dim>* J_out_pose = nullptr) {
  constexpr int kRot = kRotationDof<Dim>;
  const PointMatrix<Dim> R_inverse = pose.rotation.matrix().transpose();
  const Point<Dim> t = -(R_inverse * pose.translation);
  if (J_out_pose) {
    J_out_pose->setZero();
    J_out_pose->template topLeftCorner<Dim, Dim>() = -R_inverse;
    J_out_pose->template topRightCorner<Dim, kRot>() = -J_turned_rotation(t);
    J_out_pose->template bottomRightCorner<kRot, kRot>() = -J_after_before(pose.rotation.inverse());
  }
  return {t, pose.rotation.inverse()};
}

/// The pose `b` in the frame of `a`, both given in one parent frame (paper's (10)).
template <int Dim>
Pose<Dim> between(const Pose<Dim>& a, const Pose<Dim>& b, PoseMatrix<Dim>* J_out_a = nullptr,
                  PoseMatrix<Dim>* J_out_b = nullptr) {
  constexpr int kRot = kRotationDof<Dim>;
  const PointMatrix<Dim> R_inverse = a.rotation.matrix().transpose();
  const Pose<Dim> a_b{R_inverse * (b.translation - a.translation), a.rotation.inverse() * b.rotation};
  if (J_out_a) {
    J_out_a->setZero();
    J_out_a->template topLeftCorner<Dim, Dim>() = -R_inverse;
    J_out_a->template topRightCorner<Dim, kRot>() = -J_turned_rotation(a_b.translation);
    J_out_a->template bottomRightCorner<kRot, kRot>() = -J_after_before(a_b.rotation);
  }
  if (J_out_b) {
    J_out_b->setIdentity();
    J_out_b->template topLeftCorner<Dim, Dim>() = R_inverse;
  }
  return a_b;
}

/// A point given in the frame of `pose`, in the parent frame (paper's (1)).
template <int Dim>
Point<Dim> transform(const Pose<Dim>& pose, const Point<Dim>& p_local, PointPoseMatrix<Dim>* J_out_pose = nullptr,
                     PointMatrix<Dim>* J_out_point = nullptr) {
  const PointMatrix<Dim> R = pose.rotation.matrix();
  if (J_out_pose) {
    J_out_pose->template leftCols<Dim>().setIdentity();
    J_out_pose->template rightCols<kRotationDof<Dim>>() = R * J_turned_rotation(p_local);
  }
  if (J_out_point) *J_out_point = R;
  return pose.translation + R * p_local;
}

/// A point given in the parent frame, in the frame of `pose` (paper's (11)).
template <int Dim>
Point<Dim> transform_into(const Pose<Dim>& pose, const Point<Dim>& p_parent, PointPoseMatrix<Dim>* J_out_pose = nullptr,
                          PointMatrix<Dim>* J_out_point = nullptr) {
  const PointMatrix<Dim> R_inverse = pose.rotation.matrix().transpose();
  const Point<Dim> p_local = R_inverse * (p_parent - pose.translation);
  if (J_out_pose) {
    J_out_pose->template leftCols<Dim>() = -R_inverse;
    J_out_pose->template rightCols<kRotationDof<Dim>>() = -J_turned_rotation(p_local);
  }
  if (J_out_point) *J_out_point = R_inverse;
  return p_local;
}

}  // namespace mapjoin
