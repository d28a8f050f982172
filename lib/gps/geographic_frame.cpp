// SPDX-License-Identifier: BSD-3-Clause
#include <GeographicLib/LocalCartesian.hpp>
#include <mapjoin/gps/geographic_frame.hpp>
#include <vector>

namespace mapjoin {
namespace {

GeographicLib::LocalCartesian cartesian_at(const GeographicPoint& origin) {
  return {origin.latitude, origin.longitude, origin.height};
}

/// Rounds of the search for a place by its height: the first leaves d²/2R at d from the origin, each other one a share of
/// about (d/R)²/2 of that, so that micrometres are left at 1000 km.
constexpr int kHeightRounds = 7;

}  // namespace

Point<3> GeographicFrame::to_local(const GeographicPoint& place, Matrix<3>* R_frame_there) const {
  Point<3> local;
  std::vector<double> rows(9);
  cartesian_at(origin_).Forward(place.latitude, place.longitude, place.height, local.x(), local.y(), local.z(), rows);
  if (R_frame_there) *R_frame_there = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
  return local;
}

GeographicPoint GeographicFrame::to_geographic(const Point<3>& local) const {
  GeographicPoint place;
  cartesian_at(origin_).Reverse(local.x(), local.y(), local.z(), place.latitude, place.longitude, place.height);
  return place;
}

GeographicPoint GeographicFrame::to_geographic(const Point<2>& local) const {
  Point<3> point(local.x(), local.y(), 0.0);
  GeographicPoint place = to_geographic(point);
  for (int round = 1; round < kHeightRounds; ++round) {
    point.z() += origin_.height - place.height;
    place = to_geographic(point);
  }
  return place;
}

}  // namespace mapjoin
