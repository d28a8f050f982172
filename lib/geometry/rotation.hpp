// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Rotations in the plane and in space behind one interface, and the small vector and matrix types sized by the dimension.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace mapjoin {

/// Degrees of freedom of a rotation: 1 in the plane (rad), 3 in space (rotation vector, rad).
template <int Dim>
inline constexpr int kRotationDof = Dim == 2 ? 1 : 3;
/// Degrees of freedom of a pose: translation first (m), then rotation (rad).
template <int Dim>
inline constexpr int kPoseDof = Dim + kRotationDof<Dim>;

template <int Rows>
using Vector = Eigen::Matrix<double, Rows, 1>;
template <int Rows, int Cols = Rows>
using Matrix = Eigen::Matrix<double, Rows, Cols>;

/// A position or the position of a point feature (m).
template <int Dim>
using Point = Vector<Dim>;
/// Step of a rotation (rad).
template <int Dim>
using RotationVector = Vector<kRotationDof<Dim>>;
template <int Dim>
using RotationJacobian = Matrix<kRotationDof<Dim>>;

/// The angle equal to `angle` modulo 2π in [-π, π] (rad).
inline double wrap_angle(double angle) {
  return std::abs(angle) <= std::numbers::pi ? angle : std::remainder(angle, 2.0 * std::numbers::pi);
}

/// The cross-product matrix: skew(a) b = a × b, in the plane its component along the normal.
inline Matrix<1, 2> skew(const Vector<2>& a) {
  return {-a.y(), a.x()};
}
inline Matrix<3> skew(const Vector<3>& a) {
  return (Matrix<3>() << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0).finished();
}

template <int Dim>
class Rotation;

/// A heading φ in the plane (rad), stored as given, not wrapped, since a robot may turn many times; its cosine and sine are
/// kept for the many observations from one pose.
template <>
class Rotation<2> {
 public:
  Rotation() = default;
  explicit Rotation(double angle) : Rotation(angle, std::cos(angle), std::sin(angle)) {}

  static Rotation exp(const RotationVector<2>& v) { return Rotation(v[0]); }
  /// The heading wrapped to [-π, π].
  RotationVector<2> log() const { return RotationVector<2>(wrap_angle(angle_)); }

  double angle() const { return angle_; }
  Matrix<2> matrix() const { return (Matrix<2>() << cos_, -sin_, sin_, cos_).finished(); }
  Rotation inverse() const { return Rotation(-angle_, cos_, -sin_); }
  Rotation operator*(const Rotation& other) const { return Rotation(angle_ + other.angle_); }
  /// The same rotation with its heading in (-π, π].
  Rotation without_turns() const {
    const double heading = wrap_angle(angle_);
    return Rotation(heading == -std::numbers::pi ? std::numbers::pi : heading, cos_, sin_);
  }

 private:
  Rotation(double angle, double cos, double sin) : angle_(angle), cos_(cos), sin_(sin) {}

  double angle_ = 0.0;
  double cos_ = 1.0;
  double sin_ = 0.0;
};

/// A rotation in space, a unit quaternion.
template <>
class Rotation<3> {
 public:
  Rotation() : quaternion_(Eigen::Quaterniond::Identity()) {}
  /// `quaternion` must be of unit length.
  explicit Rotation(const Eigen::Quaterniond& quaternion) : quaternion_(quaternion) {}
  explicit Rotation(const Matrix<3>& rotation_matrix) : quaternion_(rotation_matrix) { quaternion_.normalize(); }

  static Rotation exp(const RotationVector<3>& v);
  /// The rotation vector of length at most π.
  RotationVector<3> log() const;

  const Eigen::Quaterniond& quaternion() const { return quaternion_; }
  Matrix<3> matrix() const { return quaternion_.toRotationMatrix(); }
  Rotation inverse() const { return Rotation(quaternion_.conjugate()); }
  /// The product, renormalised so that a long chain of products stays a rotation.
  Rotation operator*(const Rotation& other) const { return Rotation((quaternion_ * other.quaternion_).normalized()); }

 private:
  Eigen::Quaterniond quaternion_;
};

/// ∂(Exp(w) p)/∂w at w = 0: the direction in which p moves when it is turned. Dim × kRotationDof<Dim>.
inline Matrix<2, 1> J_turned_rotation(const Point<2>& p) {
  return Matrix<2, 1>(-p.y(), p.x());
}
inline Matrix<3, 3> J_turned_rotation(const Point<3>& p) {
  return -skew(p);
}

/// The inverse of the right Jacobian of SO(Dim) at the rotation vector `v`: Log(Exp(v) Exp(δ)) = v + J δ + O(δ²).
inline RotationJacobian<2> right_jacobian_inverse(const RotationVector<2>&) {
  return RotationJacobian<2>::Ones();
}
RotationJacobian<3> right_jacobian_inverse(const RotationVector<3>& v);

/// The second derivatives of uᵀ Log(Exp(δ) Exp(v)) with respect to δ, at δ = 0.
Matrix<3> log_curvature(const RotationVector<3>& v, const RotationVector<3>& u);

/// The matrix that takes a step on the left of `rotation` to the equal step on its right (the transpose of the adjoint):
/// Exp(w) R = R Exp(Rᵀ w).
inline RotationJacobian<2> J_after_before(const Rotation<2>&) {
  return RotationJacobian<2>::Ones();
}
inline RotationJacobian<3> J_after_before(const Rotation<3>& rotation) {
  return rotation.matrix().transpose();
}

}  // namespace mapjoin
