// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Trajectories in the TUM format. They are written by map_text.hpp.

#include <filesystem>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/error.hpp>
#include <vector>

namespace mapjoin {

struct StampedPose {
  double time = 0.0;  ///< (s), or a count where the poses have no stamps.
  Pose<3> pose;
};

/// The lines `time x y z qx qy qz qw` in their order; `#` starts a comment. Bad input, with the place, where a line is anything
/// else or a quaternion is zero; quaternions are brought to unit length.
Expected<std::vector<StampedPose>> read_tum(const std::filesystem::path& path);

}  // namespace mapjoin
