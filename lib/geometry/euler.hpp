// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Rotations in space as roll, pitch and yaw (rad), as some files give them; internally only the rotation vector is used.

#include <mapjoin/geometry/rotation.hpp>

namespace mapjoin {

/// The rotation R = Rz(yaw) Ry(pitch) Rx(roll).
Rotation<3> rotation_from_euler(double roll, double pitch, double yaw);

/// The roll, pitch and yaw of R, the pitch in [-π/2, π/2].
Vector<3> euler_from_rotation(const Rotation<3>& rotation);

/// ∂(right step of R)/∂(roll, pitch, yaw): R(angles + δ) = R(angles) Exp(J δ + O(δ²)). Its determinant is cos(pitch), so
/// it is singular at a pitch of ±π/2. An information matrix W of the angles is J⁻ᵀ W J⁻¹ of the rotation vector.
Matrix<3> J_vector_euler(double roll, double pitch, double yaw);

}  // namespace mapjoin
