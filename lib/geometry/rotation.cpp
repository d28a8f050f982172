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

RotationJacobian<3> right_jacobian_inverse(const RotationVector<3>& v) {
  const double theta2 = v.squaredNorm();
  const double theta = std::sqrt(theta2);
  // (1/θ²)(1 - (θ/2) cot(θ/2)), by its series near zero.
  const double k = theta < 1e-3 ? 1.0 / 12.0 + theta2 / 720.0 : (1.0 - 0.5 * theta / std::tan(0.5 * theta)) / theta2;
  const Matrix<3> hat = skew(v);
  return Matrix<3>::Identity() + 0.5 * hat + k * hat * hat;
}

}  // namespace mapjoin
