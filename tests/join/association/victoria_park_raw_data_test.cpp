// SPDX-License-Identifier: BSD-3-Clause
// Victoria Park from its raw detections of trees, associated; the truth is GPS.
#include <gtest/gtest.h>

#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/support/victoria_park_raw.hpp>

namespace mapjoin {
namespace {

TEST(VictoriaParkRaw, IsMappedAsGpsHasIt) {
  const Log<2> log = testing::victoria_park_raw();
  EXPECT_EQ(log.observations().size(), 52946U);
  const auto found = associate(log, AssociationOptions{}).value();
  const auto result = run(found.data, RunOptions{}).value();
  const double distance = testing::median_distance_from_gps(found.data, result.map.poses);
  RecordProperty("median_distance", std::to_string(distance));
  EXPECT_LT(distance, 1.5);
}

}  // namespace
}  // namespace mapjoin
