// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A global map as plain text: a trajectory in the TUM or KITTI format, poses and features as CSV and, for maps that stand in a
// GeographicFrame, in latitude and longitude. For g2o see g2o.hpp.

#include <cstdint>
#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <string>

namespace mapjoin {

class GeographicFrame;

/// A pose of the plane in space: z is 0, and the heading a turn about z.
Pose<3> in_space(const Pose<2>& pose);
inline const Pose<3>& in_space(const Pose<3>& pose) {
  return pose;
}

/// Seconds with nine decimals, exactly.
std::string seconds(std::int64_t nanoseconds);

/// std::invalid_argument unless the lists of a map are as long as those of the poses and features that they are of, and the
/// anchored poses are there.
template <int Dim>
void demand_whole(const GlobalMap<Dim>& map);

// Each number has the fewest digits that read back as the same bits. Files appear whole or not at all: kCannotWrite.
// std::invalid_argument of a map that is not whole.

/// `time x y z qx qy qz qw` per pose, in the map's order, after a comment that names the columns. The time is in seconds to the
/// nanosecond; where the map has no stamps it is the index of the pose, counted from 0, as the comment then says. In the plane
/// z is 0 and the heading a turn about z.
template <int Dim>
Expected<void> write_tum(const GlobalMap<Dim>& map, const std::filesystem::path& path);

/// Twelve numbers per pose, in the map's order: the rows of (R | t), as above. There are no names, no times and no comments.
template <int Dim>
Expected<void> write_kitti(const GlobalMap<Dim>& map, const std::filesystem::path& path);

/// The first table of write_csv().
template <int Dim>
Expected<void> write_pose_csv(const GlobalMap<Dim>& map, const std::filesystem::path& path);

/// Two tables; neither appears unless both could be written. kUsage where both paths lead to one file.
/// - Poses: `pose,x,y,phi` or `pose,x,y,z,qx,qy,qz,qw`, under a header with these names (m, rad); before them `session,` where
///   any pose is of a session other than 0, behind them `,stamp_ns` where the map has stamps. Then, where the map has
///   covariances, the upper triangle of the pose's, row by row, as `,cov_x_x,cov_x_y,cov_x_phi,…`; in space over x, y, z and
///   the rotation vector rx, ry, rz on the right.
/// - Features: `feature,x,y` or `feature,x,y,z`, under a header with these names (m), also where there are none; then the
///   covariance, likewise.
template <int Dim>
Expected<void> write_csv(const GlobalMap<Dim>& map, const std::filesystem::path& poses, const std::filesystem::path& features);

/// A table of poses as that of write_csv(), with `latitude,longitude` (°) and, in space, `height` (m) for the pose; in the
/// plane places have no height.
template <int Dim>
Expected<void> write_geographic_csv(const GlobalMap<Dim>& map, const GeographicFrame& frame, const std::filesystem::path& path);

/// GeoJSON (RFC 7946): the trajectory of each session as a LineString, or as a MultiLineString cut at the antimeridian where it
/// crosses that, or a single pose as a Point; each feature as a Point.
template <int Dim>
Expected<void> write_geojson(const GlobalMap<Dim>& map, const GeographicFrame& frame, const std::filesystem::path& path);

}  // namespace mapjoin
