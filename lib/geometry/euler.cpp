// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/geometry/euler.hpp>

namespace mapjoin {

Rotation<3> rotation_from_euler(double roll, double pitch, double yaw) {
  using Eigen::AngleAxisd;
  return Rotation<3>(Eigen::Quaterniond(AngleAxisd(yaw, Vector<3>::UnitZ()) * AngleAxisd(pitch, Vector<3>::UnitY()) *
                                        AngleAxisd(roll, Vector<3>::UnitX())));
}

Vector<3> euler_from_rotation(const Rotation<3>& rotation) {
  const Matrix<3> R = rotation.matrix();
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  // Roll from Rz(yaw)ᵀ R: at a pitch of ±π/2 yaw is arbitrary, but roll and yaw together still give R.
  const double s = std::sin(yaw);
  const double c = std::cos(yaw);
  const double roll = std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1));
  return {roll, std::atan2(-R(2, 0), cos_pitch), yaw};
}

Matrix<3> J_vector_euler(double roll, double pitch, double /*yaw*/) {
  // Column by column: the axes of roll, pitch and yaw in the turned frame, e_x, Rxᵀ e_y and Rxᵀ Ryᵀ e_z.
  const double s = std::sin(roll);
  const double c = std::cos(roll);
  return (Matrix<3>() << 1.0, 0.0, -std::sin(pitch),  //
          0.0, c, s * std::cos(pitch),                //
          0.0, -s, c * std::cos(pitch))
      .finished();
}

}  // namespace mapjoin
