// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The raw data of Victoria Park (wheel speed, steering, and trees detected by the laser) as a log of unassociated features.

#include <mapjoin/model/log.hpp>

namespace mapjoin::testing {

/// A log with a pose for each scan that detects a tree: the middle of the rear axle at its time. Each detection is a feature of
/// its own.
///
/// The vehicle (L = 2.83 m, H = 0.76 m, the encoder on the left rear wheel) has v = v_wheel / (1 - tan(s) H / L), s its
/// steering, and turns by tan(s) v / L; the laser is 3.78 m ahead and 0.5 m to the left. Standard deviations, as of the data's
/// authors: speed 0.02 m/s, steering 2 degrees, besides 0.2 m along and across and 1 degree of heading after a second; range
/// 0.1 m + 0.01 of it, bearing 1 degree. Scans have no times of their own: start and period of the scanner are such that they
/// agree with the times of the associated data within 10 ms.
Log<2> victoria_park_raw();

/// The median distance (m) of a trajectory from the GPS fixes of the drive, after an alignment by the rigid motion and the
/// lever of the antenna that minimise the sum of all distances.
double median_distance_from_gps(const Log<2>& log, const Table<PoseIndex, Pose<2>>& poses);

}  // namespace mapjoin::testing
