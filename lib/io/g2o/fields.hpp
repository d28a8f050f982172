// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The elements of the lines of a g2o file: poses, the sensor offsets that observations in space name, and information matrices,
// turned into those of the residual used inside.
//
// g2o's pose-pose error is E = Z⁻¹ X_b⁻¹ X_t. Its translation is -R_Zᵀ r_t, where r_t = t̂ - R_bᵀ(t_t - t_b) is ours, and its
// rotation R_Zᵀ R_bᵀ R_t has the rotation vector -r_φ; as a quaternion, the vector part -r_φ/2 to first order. With E = -A r,
// the matrix for r is Aᵀ W A.

#include <cstdint>
#include <map>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

inline constexpr std::string_view kG2oFix = "FIX";
inline constexpr std::string_view kG2oOffset = "PARAMS_SE3OFFSET";

/// True for PARAMS_SE3OFFSET and similar tags, whose lines have no effect until an observation names them.
constexpr bool is_g2o_parameter(std::string_view tag) {
  return tag.starts_with("PARAMS_");
}

/// Reads `x y φ`, or `x y z qx qy qz qw`; a quaternion is normalised, one far from unit length is rejected.
template <int Dim>
Pose<Dim> read_g2o_pose(TextScanner& text);
template <>
Pose<2> read_g2o_pose<2>(TextScanner& text);
template <>
Pose<3> read_g2o_pose<3>(TextScanner& text);

/// Poses of sensors in the frame of the robot, by the id that observations name them by.
using G2oOffsets = std::map<std::uint64_t, Pose<3>>;

/// The offsets in all lines `PARAMS_SE3OFFSET id x y z qx qy qz qw` of the file at whose start `text` stands; bad input if an
/// id has two.
Expected<G2oOffsets> read_g2o_offsets(TextScanner text);

/// The information matrix `W` of a g2o file's pose-pose edge that measured `measured`, turned to that of the paper's residual
/// with the rotation vector. Exactly symmetric if `W` is.
template <int Dim>
PoseMatrix<Dim> from_g2o(const PoseMatrix<Dim>& W, const Pose<Dim>& measured, const ReadOptions& options);

/// The error of options that turn information matrices, in a sentence that begins with `file`, which is not in g2o.
tl::unexpected<Error> not_in_g2o(const std::string& file);

/// The information matrix W of a vector, turned from a frame with `rotation` in its parent to the parent frame: R W Rᵀ. Exactly
/// symmetric.
template <int Dim>
PointMatrix<Dim> turned_to_parent(const PointMatrix<Dim>& W, const Rotation<Dim>& rotation);

}  // namespace mapjoin
