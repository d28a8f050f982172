// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Folders of the UTIAS multi-robot data (MRCLAM): velocities of robots, and landmarks seen by range and bearing.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Standard deviations of velocities and sightings, which the files do not give; from the differences between data set 6 and
/// motion capture.
struct MrclamNoise {
  double forward = 0.02;   ///< Along the way, after one second (m/√s).
  double sideways = 0.01;  ///< Across the way, after one second (m/√s).
  double turn = 0.03;      ///< Heading, after one second (rad/√s).
  double range = 0.15;     ///< (m)
  double bearing = 0.02;   ///< (rad)
};

/// True if the folder has a `Barcodes.dat`, as folders of MRCLAM data do.
bool is_mrclam_folder(const std::filesystem::path& path);

/// The planar log of all robots in the folder: `Barcodes.dat`, and `RobotN_Odometry.dat` and `RobotN_Measurement.dat`, both of
/// which may be packed (.gz). Robot N is session N-1. Its poses 0, 1, …, with time stamps, are at its first line of odometry
/// and at every later time when it saw a landmark or a robot, or was seen by one; times within 0.1 ms share a pose. Velocities
/// hold until the next line, and motion between poses is integrated along arcs; lines are taken in the order of their times.
/// Landmarks are the subjects from 6 on, under these numbers; range and bearing become x and y with the covariance J diag(σ²)
/// Jᵀ. A sighting of a robot is a closure between the poses of both that does not measure rotation: the rows of its information
/// matrix for φ are zero. Sightings of unknown barcodes and of the robot itself are left out and counted as unassociated; those
/// of robots that are not in the folder, and before the first odometry of either robot, are counted in Log::skipped.
Expected<AnyLog> read_mrclam(const std::filesystem::path& folder, const MrclamNoise& noise = {});

}  // namespace mapjoin
