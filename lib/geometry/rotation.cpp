// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/geometry/rotation.hpp>

namespace mapjoin {

Rotation<3> Rotation<3>::exp(const RotationVector<3>& v) {
  const double theta = v.norm();
  const double half = 0.5 * theta;
  // sin(θ/2)/θ, by its series where the quotient would lose digits.
  const double k = theta < 1e-4 ? 0.5 - theta * theta / 48.0 : std::sin(half) / theta;
  return Rotation(Eigen::Quaterniond(std::cos(half), k * v.x(), k * v.y(), k * v.z()).normalized());
}

RotationVector<3> Rotation<3>::log() const {
  const double sign = quaternion_.w() < 0.0 ? -1.0 : 1.0;
  const Vector<3> vec = sign * quaternion_.vec();
  const double w = sign * quaternion_.w();
  const double n = vec.norm();
  // θ/sin(θ/2) with θ = 2 atan2(n, w); 2/w (1 - n²/(3w²)) is its series.
  const double k = n < 1e-4 ? 2.0 / w * (1.0 - n * n / (3.0 * w * w)) : 2.0 * std::atan2(n, w) / n;
  return k * vec;
}

namespace {

/// The coefficient k(θ²) = (1/θ²)(1 - (θ/2) cot(θ/2)) of J⁻¹ = I ± ½ [v] + k [v]², θ = |v|; by its series near zero.
double k_of(double theta2) {
  const double half = 0.5 * std::sqrt(theta2);
  return theta2 < 1e-6 ? 1.0 / 12.0 + theta2 / 720.0 : (1.0 - half / std::tan(half)) / theta2;
}

/// The derivative dk/d(θ²).
double k_slope(double theta2) {
  const double half = 0.5 * std::sqrt(theta2);
  if (theta2 < 1e-3) return 1.0 / 720.0 + theta2 / 15120.0 + theta2 * theta2 / 403200.0;
  const double sine = std::sin(half);
  return (0.25 / (sine * sine) + 0.25 / (half * std::tan(half)) - 2.0 / theta2) / (2.0 * theta2);
}

}  // namespace

RotationJacobian<3> right_jacobian_inverse(const RotationVector<3>& v) {
  const Matrix<3> hat = skew(v);
  return Matrix<3>::Identity() + 0.5 * hat + k_of(v.squaredNorm()) * hat * hat;
}

Matrix<3> log_curvature(const RotationVector<3>& v, const RotationVector<3>& u) {
  // The gradient is J⁻ᵀu = u + ½ v × u + k v × (v × u), with J⁻¹ = I - ½ [v] + k [v]² for a step δ on the left; its derivative
  // follows from v moving by J⁻¹ δ. The term from the moving frame of δ is antisymmetric and drops out.
  const double theta2 = v.squaredNorm();
  const Matrix<3> along = v.dot(u) * Matrix<3>::Identity() + v * u.transpose() - 2.0 * u * v.transpose();
  const Matrix<3> change = -0.5 * skew(u) + k_of(theta2) * along + 2.0 * k_slope(theta2) * v.cross(v.cross(u)) * v.transpose();
  const Matrix<3> H = change * right_jacobian_inverse(RotationVector<3>(-v));
  return 0.5 * (H + H.transpose());
}

}  // namespace mapjoin
