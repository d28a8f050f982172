// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Logs in the text formats of TORO and iSAM, whose rotations are angles: `x y φ`, or `x y z roll pitch yaw` with
// R = Rz(yaw) Ry(pitch) Rx(roll).

#include <filesystem>
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

// Pose graphs in TORO's format: `VERTEX2 EDGE2` in the plane, `VERTEX3 EDGE3` in space.

/// Whether a line that begins with `tag` is TORO's: its edges have the tags of iSAM's, its vertices are its own.
bool is_toro_vertex_tag(std::string_view tag);

/// The log in `text`, which stands at the begin of a file of lines
/// - `VERTEX2 i x y φ`, `EDGE2 i j dx dy dφ Wxx Wxy Wyy Wφφ Wxφ Wyφ` (mind the order), or
/// - `VERTEX3 i x y z roll pitch yaw`, `EDGE3 i j dx dy dz roll pitch yaw` and the upper triangle of W, row by row, over these
///   numbers; R = Rz(yaw) Ry(pitch) Rx(roll).
/// W is an information matrix; that of the three angles is turned to the rotation vector at the measurement.
Expected<AnyLog> read_toro(TextScanner text, const ReadOptions& options);

/// Edges and the values of poses, which the log must have (see write_edge_text()); features and their observations have no
/// place in it.
template <int Dim>
Expected<void> write_toro(const Log<Dim>& log, const std::filesystem::path& path);

// Logs in iSAM's format: `EDGE2 LANDMARK` in the plane, `EDGE3 POINT3` in space, with square roots of information matrices.

/// Whether a line of an iSAM log may begin with `tag`.
bool is_isam_tag(std::string_view tag);

/// The log in `text`, which stands at the begin of a file of lines
/// - `EDGE2 i j dx dy dφ S`, `LANDMARK i feature x y S`, or
/// - `EDGE3 i j dx dy dz roll pitch yaw S`, `POINT3 i feature x y z S`, with R = Rz(yaw) Ry(pitch) Rx(roll).
/// S is the upper triangle, row by row, of a square root of the information matrix, W = SᵀS, over the numbers of the line in
/// their order; W of the three angles is turned to the rotation vector with the Jacobian at the measurement, which is bad input
/// where the pitch is a right angle. Poses and features are named apart.
Expected<AnyLog> read_isam(TextScanner text, const ReadOptions& options);

/// Edges and observations (see write_edge_text()). The square root is rounded, and so are the angles in space.
template <int Dim>
Expected<void> write_isam(const Log<Dim>& log, const std::filesystem::path& path);

}  // namespace mapjoin
