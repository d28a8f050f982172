// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Poses of text formats whose rotations are angles: `x y φ`, or `x y z roll pitch yaw` with R = Rz(yaw) Ry(pitch) Rx(roll), and
// the weights of these numbers turned to those of a step, and back.

#include <mapjoin/io/formats/edge_text.hpp>

namespace mapjoin {

/// A pose as numbers, and J = ∂numbers/∂step there: a matrix W over the numbers is JᵀWJ over the step.
template <int Dim>
struct PoseAngles {
  PoseVector<Dim> numbers;
  PoseMatrix<Dim> J_numbers_step;
};

/// The next numbers of the line. A pitch of a right angle, where roll and yaw are not told apart, is rejected.
template <int Dim>
std::pair<Pose<Dim>, PoseMatrix<Dim>> read_pose_angles(TextScanner& text);

/// Nothing at a pitch of a right angle.
template <int Dim>
std::optional<PoseAngles<Dim>> pose_angles(const Pose<Dim>& pose);

inline constexpr const char* kRightAnglePitch = "has a pitch of a right angle";

}  // namespace mapjoin
