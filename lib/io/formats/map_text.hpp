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

/// A planar pose in space: z is 0, and the heading a turn about z.
Pose<3> in_space(const Pose<2>& pose);
inline const Pose<3>& in_space(const Pose<3>& pose) {
  return pose;
}

/// A time in seconds with nine decimals, exactly.
std::string seconds(std::int64_t nanoseconds);

/// Throws std::invalid_argument unless the lists of a map are as long as those of their poses and features, all values and
/// covariances are finite, and the anchored poses are in the map.
template <int Dim>
void demand_whole(const GlobalMap<Dim>& map);

// Numbers have the fewest digits that read back as the same bits. Files appear whole or not at all: kCannotWrite. The writers
// throw std::invalid_argument if the map is not whole (see demand_whole).

/// Writes the poses in TUM's format, lines `time x y z qx qy qz qw` in the map's order, after a comment that names the columns.
/// The time is in seconds to the nanosecond; if the map has no stamps it is the index of the pose, counted from 0, and the
/// comment says so. In the plane z is 0 and the heading a turn about z.
template <int Dim>
Expected<void> write_tum(const GlobalMap<Dim>& map, const std::filesystem::path& path);

/// Writes the poses in KITTI's format, twelve numbers per line in the map's order: the rows of (R | t); in the plane z is 0 and
/// R a turn about z. Names, times and comments have no place in the format.
template <int Dim>
Expected<void> write_kitti(const GlobalMap<Dim>& map, const std::filesystem::path& path);

/// Writes the table of poses, the first of write_csv().
template <int Dim>
Expected<void> write_pose_csv(const GlobalMap<Dim>& map, const std::filesystem::path& path);

/// Writes two tables; neither appears unless both could be written. kUsage if both paths lead to one file.
/// - Poses: `pose,x,y,phi` or `pose,x,y,z,qx,qy,qz,qw`, under a header with these names (m, rad); `session,` stands before them
/// if any pose is of a session other than 0, `,stamp_ns` behind them if the map has stamps. If the map has covariances, the
/// upper triangle of the pose's follows, row by row, as `,cov_x_x,cov_x_y,cov_x_phi,…`; in space over x, y, z and the rotation
/// vector rx, ry, rz on the right.
/// - Features: `feature,x,y` or `feature,x,y,z`, under a header with these names (m), even if there are no features; then the
/// upper triangle of the feature's covariance in the same way.
template <int Dim>
Expected<void> write_csv(const GlobalMap<Dim>& map, const std::filesystem::path& poses, const std::filesystem::path& features);

/// Writes the table of poses of write_csv() without covariances, with `latitude,longitude` (°) and, in space, `height` (m) for
/// the pose.
template <int Dim>
Expected<void> write_geographic_csv(const GlobalMap<Dim>& map, const GeographicFrame& frame, const std::filesystem::path& path);

/// Writes GeoJSON (RFC 7946): the trajectory of each session as a LineString, as a MultiLineString cut at the antimeridian if
/// it crosses that, or as a Point if it is a single pose; each feature as a Point.
template <int Dim>
Expected<void> write_geojson(const GlobalMap<Dim>& map, const GeographicFrame& frame, const std::filesystem::path& path);

}  // namespace mapjoin
