// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <mapjoin/geometry/euler.hpp>
#include <mapjoin/io/formats/euler_angles.hpp>
#include <mapjoin/io/g2o/fields.hpp>

namespace mapjoin {
namespace {

constexpr double kLeastCosine = 1e-6;

/// ∂(x, y, z, roll, pitch, yaw)/∂step.
Matrix<6> J_numbers_step(double roll, double pitch, double yaw) {
  Matrix<6> J = Matrix<6>::Identity();
  J.bottomRightCorner<3, 3>() = J_vector_euler(roll, pitch, yaw).inverse();
  return J;
}

}  // namespace

template <>
std::pair<Pose<2>, PoseMatrix<2>> read_pose_angles(TextScanner& text) {
  return {read_g2o_pose<2>(text), PoseMatrix<2>::Identity()};
}

template <>
std::pair<Pose<3>, PoseMatrix<3>> read_pose_angles(TextScanner& text) {
  const Vector<3> translation = text.vector<3>();
  const double roll = text.number();
  double pitch = text.number();
  if (std::abs(std::cos(pitch)) < kLeastCosine) {
    text.reject("at a pitch of a right angle roll and yaw are not told apart");
    pitch = 0.0;
  }
  const double yaw = text.number();
  const Rotation<3> rotation(rotation_from_euler(roll, pitch, yaw).quaternion().normalized());
  return {{translation, rotation}, J_numbers_step(roll, pitch, yaw)};
}

template <>
std::optional<PoseAngles<2>> pose_angles(const Pose<2>& pose) {
  return PoseAngles<2>{{pose.translation.x(), pose.translation.y(), pose.rotation.angle()}, PoseMatrix<2>::Identity()};
}

template <>
std::optional<PoseAngles<3>> pose_angles(const Pose<3>& pose) {
  const Vector<3> angles = euler_from_rotation(pose.rotation);
  if (std::abs(std::cos(angles[1])) < kLeastCosine) return std::nullopt;
  PoseAngles<3> as_angles;
  as_angles.numbers << pose.translation, angles;
  as_angles.J_numbers_step = J_numbers_step(angles[0], angles[1], angles[2]);
  return as_angles;
}

}  // namespace mapjoin
