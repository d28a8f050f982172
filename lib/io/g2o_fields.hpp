// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the lines of a g2o file are made of: poses, and the sensor offsets that observations in space name.

#include <cstdint>
#include <map>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/io/text_scanner.hpp>

namespace mapjoin {

/// `x y φ`, or `x y z qx qy qz qw`. A quaternion is normalised, one far from unit length is rejected.
template <int Dim>
Pose<Dim> read_g2o_pose(TextScanner& text);

/// Poses of sensors in the frame of the robot, by the id that observations name them by.
using G2oOffsets = std::map<std::uint64_t, Pose<3>>;

/// All `PARAMS_SE3OFFSET id x y z qx qy qz qw` of the file at whose begin `text` stands.
Expected<G2oOffsets> read_g2o_offsets(TextScanner text);

}  // namespace mapjoin
