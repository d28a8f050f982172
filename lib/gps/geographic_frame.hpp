// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A local frame on the earth, x east, y north, z up, and the places in it.

#include <mapjoin/geometry/pose.hpp>

namespace mapjoin {

/// A place on the earth (WGS 84).
struct GeographicPoint {
  double latitude = 0.0;   ///< (°)
  double longitude = 0.0;  ///< (°)
  double height = 0.0;     ///< Above the ellipsoid (m).
};

/// The Cartesian frame that touches the ellipsoid's parallel at its origin.
class GeographicFrame {
 public:
  GeographicFrame() = default;
  explicit GeographicFrame(const GeographicPoint& origin) : origin_(origin) {}

  const GeographicPoint& origin() const { return origin_; }
  /// A place in the frame (m); `R_frame_there` is that of east, north and up at the place.
  Point<3> to_local(const GeographicPoint& place, Matrix<3>* R_frame_there = nullptr) const;
  GeographicPoint to_geographic(const Point<3>& local) const;

 private:
  GeographicPoint origin_;
};

}  // namespace mapjoin
