// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <mapjoin/gps/geographic_frame.hpp>
#include <numbers>

namespace mapjoin {
namespace {

const GeographicPoint kOrigin{-33.885, 151.19, 30.0};

TEST(GeographicFrame, IsEastNorthUpAtItsOrigin) {
  const GeographicFrame frame(kOrigin);
  EXPECT_LT(frame.to_local(kOrigin).norm(), 1e-8);
  const double degree = std::numbers::pi / 180.0;
  // Radii of curvature of WGS 84 at the origin's latitude.
  const double a = 6378137.0, e2 = 6.69437999014e-3, s = std::sin(kOrigin.latitude * degree);
  const double across = a / std::sqrt(1.0 - e2 * s * s) + kOrigin.height;
  const double along = a * (1.0 - e2) / std::pow(1.0 - e2 * s * s, 1.5) + kOrigin.height;
  const Point<3> north = frame.to_local({kOrigin.latitude + 1e-4, kOrigin.longitude, kOrigin.height});
  const Point<3> east = frame.to_local({kOrigin.latitude, kOrigin.longitude + 1e-4, kOrigin.height});
  EXPECT_LT((north - Point<3>(0.0, 1e-4 * degree * along, 0.0)).norm(), 1e-4);
  EXPECT_LT((east - Point<3>(1e-4 * degree * across * std::cos(kOrigin.latitude * degree), 0.0, 0.0)).norm(), 1e-4);
  EXPECT_LT((frame.to_local({kOrigin.latitude, kOrigin.longitude, 35.0}) - Point<3>(0.0, 0.0, 5.0)).norm(), 1e-8);
}

TEST(GeographicFrame, LeadsThereAndBack) {
  const GeographicFrame frame(kOrigin);
  const Point<3> local(1234.5, -987.6, 54.3);
  const GeographicPoint place = frame.to_geographic(local);
  EXPECT_LT((frame.to_local(place) - local).norm(), 1e-8);
}

TEST(GeographicFrame, OfAPlaneLeadsThereAndBackAtTheHeightOfItsOrigin) {
  const GeographicFrame frame(kOrigin);
  for (const double away : {0.0, 10e3, 100e3, 1000e3}) {
    const Point<2> local(0.6 * away, -0.8 * away);
    const GeographicPoint place = frame.to_geographic(local);
    EXPECT_NEAR(place.height, kOrigin.height, 1e-5) << away;
    EXPECT_LT((frame.to_local(place).head<2>() - local).norm(), 1e-5) << away;
  }
}

TEST(GeographicFrame, TurnsEastNorthAndUpOfAPlaceIntoTheFrame) {
  const GeographicFrame frame(kOrigin);
  const GeographicPoint place{kOrigin.latitude + 1.0, kOrigin.longitude - 2.0, 100.0};
  Matrix<3> R;
  const Point<3> there = frame.to_local(place, &R);
  EXPECT_LT((R * R.transpose() - Matrix<3>::Identity()).norm(), 1e-12);
  EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
  const Point<3> above = frame.to_local({place.latitude, place.longitude, 101.0});
  EXPECT_LT((above - there - R.col(2)).norm(), 1e-6);
  const Point<3> north = frame.to_local({place.latitude + 1e-5, place.longitude, 100.0}) - there;
  EXPECT_LT((north.normalized() - R.col(1)).norm(), 1e-5);
}

}  // namespace
}  // namespace mapjoin
