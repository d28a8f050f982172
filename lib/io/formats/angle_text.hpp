// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Logs in the text formats of TORO and iSAM, whose rotations are angles: `x y φ`, or `x y z roll pitch yaw` with
// R = Rz(yaw) Ry(pitch) Rx(roll).

#include <mapjoin/io/formats/edge_text.hpp>

namespace mapjoin {

/// A pose as numbers, and J = ∂numbers/∂step there: a matrix W over the numbers is JᵀWJ over the step.
template <int Dim>
struct PoseAngles {
  PoseVector<Dim> numbers;
  PoseMatrix<Dim> J_numbers_step;
};

/// The pose as numbers; nullopt at a pitch of a right angle, where roll and yaw are one rotation, and J is infinite.
template <int Dim>
std::optional<PoseAngles<Dim>> pose_angles(const Pose<Dim>& pose);

inline constexpr const char* kRightAnglePitch = "has weights at a pitch of a right angle";

/// Pose graphs in TORO's format, files of lines
/// - `VERTEX2 i x y φ`, `EDGE2 i j dx dy dφ Wxx Wxy Wyy Wφφ Wxφ Wyφ` (mind the order), or
/// - `VERTEX3 i x y z roll pitch yaw`, `EDGE3 i j dx dy dz roll pitch yaw` and the upper triangle of W, row by row, over these
/// numbers; R = Rz(yaw) Ry(pitch) Rx(roll).
/// W is an information matrix; that of the three angles is turned to the rotation vector at the measurement, which cannot be at
/// a pitch of a right angle. Poses must have values; the format has no place for features and observations.
extern const EdgeText<2> kToroPlane;
extern const EdgeText<3> kToroSpace;

/// Logs in iSAM's format, files of lines
/// - `EDGE2 i j dx dy dφ S`, `LANDMARK i feature x y S`, or
/// - `EDGE3 i j dx dy dz roll pitch yaw S`, `POINT3 i feature x y z S`, with R = Rz(yaw) Ry(pitch) Rx(roll).
/// S is the upper triangle, row by row, of a square root of the information matrix, W = SᵀS, over the numbers of the line in
/// their order; W of the three angles is turned to the rotation vector with the Jacobian at the measurement. A pitch of a right
/// angle is bad input. Written square roots are rounded, and so are the angles in space.
extern const EdgeText<2> kIsamPlane;
extern const EdgeText<3> kIsamSpace;

}  // namespace mapjoin
