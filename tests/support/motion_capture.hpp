// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The trajectories of the robots of the UTIAS multi-robot data (MRCLAM) by motion capture.

#include <filesystem>
#include <map>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>

namespace mapjoin::testing {

using Trajectory = std::map<double, Pose<2>>;  // poses by time (s)

/// The trajectory in a `RobotN_Groundtruth.dat`.
inline Trajectory motion_capture(const std::filesystem::path& file) {
  const auto bytes = FileBytes::read(file).value();
  Trajectory truth;
  for (TextScanner text(file.string(), bytes.view()); text.next_line();) {
    const double time = text.number();
    const auto v = text.vector<3>();
    truth[time] = {v.head<2>(), Rotation<2>(v[2])};
  }
  return truth;
}

}  // namespace mapjoin::testing
