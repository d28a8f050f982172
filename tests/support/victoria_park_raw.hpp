// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The raw data of Victoria Park, wheel speed, steering and what the laser saw of trees, as a log without names.

#include <mapjoin/model/log.hpp>

namespace mapjoin::testing {

/// A pose a scan, where the middle of the rear axle was, with its time. Each detection of a tree is a feature of its own.
///
/// The vehicle (L = 2.83 m, H = 0.76 m, the encoder on the left rear wheel) has v = v_wheel / (1 - tan(s) H / L) and turns by
/// tan(s) v / L; the laser is 3.78 m ahead and 0.5 m to the left. Standard deviations, as of the data's authors: speed 0.02
/// m/s, steering 2 degrees, after each second 0.2 m along and across the way, and a degree of heading; range 0.1 m + 0.01 of
/// it, bearing 1 degree. Scans carry no times: the scanner's period is by comparison with those of the associated data, within
/// 10 ms.
Log<2> victoria_park_raw();

/// The median distance (m) of a trajectory from the GPS fixes of the drive, aligned by a rigid motion and the antenna's lever
/// arm, of which the sum of all distances is least.
double median_distance_from_gps(const Log<2>& log, const Table<PoseIndex, Pose<2>>& poses);

}  // namespace mapjoin::testing
