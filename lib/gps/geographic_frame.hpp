// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Places on the earth, and a local frame there: x east, y north, z up at its origin.

#include <mapjoin/geometry/pose.hpp>

namespace mapjoin {

/// A place on the earth (WGS 84).
struct GeographicPoint {
  double latitude = 0.0;   ///< (°)
  double longitude = 0.0;  ///< (°)
  double height = 0.0;     ///< Above the ellipsoid (m).
};

/// The local Cartesian frame at its origin: x east, y north, z up along the normal of the ellipsoid. A map in the plane holds
/// x and y of what lies at the height of the origin, below the tangent plane by 0.7 m in 3 km and by 785 m in 100 km.
class GeographicFrame {
 public:
  GeographicFrame() = default;
  explicit GeographicFrame(const GeographicPoint& origin) : origin_(origin) {}

  const GeographicPoint& origin() const { return origin_; }
  /// A place in the frame (m); `R_frame_there` takes east, north and up at the place to the frame.
  Point<3> to_local(const GeographicPoint& place, Matrix<3>* R_frame_there = nullptr) const;
  GeographicPoint to_geographic(const Point<3>& local) const;
  /// The place at the height of the origin that has these x and y (m).
  GeographicPoint to_geographic(const Point<2>& local) const;

 private:
  GeographicPoint origin_;
};

}  // namespace mapjoin
