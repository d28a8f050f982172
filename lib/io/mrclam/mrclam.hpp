// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Folders of the UTIAS multi-robot data (MRCLAM): velocities of robots, and landmarks seen by range and bearing.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// How certain velocities and sightings are, which the files do not say: by the differences of data set 6 to motion capture.
struct MrclamNoise {
  double forward = 0.02;   ///< Of the way, along it, after one second (m/√s).
  double sideways = 0.01;  ///< And across it (m/√s).
  double turn = 0.03;      ///< Of the heading, after one second (rad/√s).
  double range = 0.15;     ///< Of a range (m).
  double bearing = 0.02;   ///< Of a bearing (rad).
};

/// Whether the folder has a `Barcodes.dat`, as these do.
bool is_mrclam_folder(const std::filesystem::path& path);

/// The planar log of all robots in the folder: `Barcodes.dat`, and `RobotN_Odometry.dat` and `RobotN_Measurement.dat`, each of
/// which may be packed (.gz). Robot N is session N - 1; its poses 0, 1, … are its first line of odometry and every time after
/// that at which it saw a landmark or a robot, or was seen by one, with time stamps. Velocities hold until the next line, and
/// motion between poses is integrated along arcs; lines are taken in the order of their times. Landmarks are the subjects from
/// 6 on, by these numbers, turned from range and bearing to x and y with the covariance J diag(σ²) Jᵀ. A robot that is seen is
/// a closure between the poses of both, which says nothing of how they are turned: the rows of its information matrix for φ are
/// zero. Sightings of unknown barcodes, of robots that are not in the folder, and those before the first odometry of either
/// robot are left out and counted as unassociated.
Expected<AnyLog> read_mrclam(const std::filesystem::path& folder, const MrclamNoise& noise = {});

}  // namespace mapjoin
