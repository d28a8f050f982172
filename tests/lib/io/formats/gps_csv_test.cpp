// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/formats/gps_csv.hpp>

namespace mapjoin {
namespace {

using ::testing::StartsWith;

TEST(GpsCsv, ColumnsComeInAnyOrderAndOthersArePassedOver) {
  const auto fixes = read_gps_csv(
                         "longitude,quality,latitude,height,sd_up,sd_north,sd_east,session,time\n"
                         "8.5,4,50.25,120,3,2,1,0,1.000000001\n8.6,x,50.5,121,3,2,1,7,2\n",
                         "fixes.csv")
                         .value();
  ASSERT_EQ(fixes.fixes.size(), 2U);
  EXPECT_TRUE(fixes.has_heights);
  const GpsFix& first = fixes.fixes[0];
  EXPECT_EQ(first.line, 2U);
  EXPECT_EQ(std::get<std::int64_t>(first.when), 1'000'000'001);
  EXPECT_EQ(first.place.latitude, 50.25);
  EXPECT_EQ(first.place.longitude, 8.5);
  EXPECT_EQ(first.place.height, 120.0);
  EXPECT_EQ(first.deviation, Vector<3>(1.0, 2.0, 3.0));
  EXPECT_EQ(fixes.fixes[1].session, 7U);
}

TEST(GpsCsv, BlanksAroundTheNamesOfColumnsDoNotCount) {
  const auto fixes = read_gps_csv("pose, latitude , longitude,\tsd_east, sd_north\n12, 50, 8, 1, 1\n", "fixes.csv").value();
  EXPECT_EQ(fixes.fixes[0].place.longitude, 8.0);
}

TEST(GpsCsv, NamesOfColumnsMayBeQuoted) {
  const auto fixes = read_gps_csv("\"pose\",\"latitude\", \"longitude\" ,\"sd_east\",\"sd_north\"\n12,50,8,1,1\n", "fixes.csv");
  ASSERT_TRUE(fixes) << fixes.error().message;
  EXPECT_EQ(fixes->fixes[0].place.longitude, 8.0);
}

TEST(GpsCsv, ACellOfAnotherColumnMayHaveSeveralWords) {
  const auto fixes = read_gps_csv(
                         "utc,time,latitude,longitude,mode,sd_east,sd_north\n"
                         "2024-05-01 12:00:00,1,50,8, 3D FIX ,1,2\n2024-05-01 12:00:01 ,2,51,9,none,1,2 # a comment, too\n",
                         "fixes.csv")
                         .value();
  EXPECT_EQ(fixes.fixes[0].place.longitude, 8.0);
  EXPECT_EQ(fixes.fixes[1].place.latitude, 51.0);
  EXPECT_EQ(fixes.fixes[1].deviation.y(), 2.0);
}

TEST(GpsCsv, InThePlaneThereNeedBeNoHeights) {
  const auto fixes = read_gps_csv("pose,latitude,longitude,sd_east,sd_north\n12,50,8,1,1\n", "fixes.csv").value();
  EXPECT_FALSE(fixes.has_heights);
  EXPECT_EQ(std::get<std::uint64_t>(fixes.fixes[0].when), 12U);
}

TEST(GpsCsv, HeightsCountWhereTheirDeviationIsKnown) {
  const auto fixes = read_gps_csv("pose,latitude,longitude,height,sd_east,sd_north\n12,50,8,100,1,1\n", "fixes.csv").value();
  EXPECT_FALSE(fixes.has_heights);
}

void expect_refused(const std::string& text, const std::string& message) {
  const auto fixes = read_gps_csv(text, "fixes.csv");
  ASSERT_FALSE(fixes);
  EXPECT_THAT(fixes.error().message, StartsWith(message));
}

TEST(GpsCsv, WhatIsWrongIsNamedWithItsPlace) {
  const std::string head = "time,latitude,longitude,sd_east,sd_north\n";
  expect_refused("", "fixes.csv:1: names no column time or pose");
  expect_refused("time,latitude,longitude,sd_east\n1,2,3,4\n", "fixes.csv:1: names no column sd_north");
  expect_refused("time,latitude,longitude,sd_east,sd_north,latitude\n",
                 "fixes.csv:1: names the column latitude more than once");
  expect_refused("time,pose,latitude,longitude,sd_east,sd_north\n", "fixes.csv:1: names both columns time and pose");
  expect_refused(head, "fixes.csv: has no fixes behind its header");
  expect_refused(head + "1,50 8,1,1,1\n", "fixes.csv:2:3: '50_8' stands where a number is expected");
  expect_refused(head + "1,50,8,1,1\nnoon,50,8,1,1\n", "fixes.csv:3:1: a time in seconds is expected, not 'noon'");
  expect_refused(head + "1,95,8,1,1\n", "fixes.csv:2:3: an angle from -90 to 90 degrees is expected");
  expect_refused(head + "1,50,8,0,1\n", "fixes.csv:2:8: a standard deviation is from 1e-6 to 1e6 m");
  expect_refused(head + "1,50,8,,1\n", "fixes.csv:2:8: '(empty)' stands where a number is expected");
  expect_refused("time,latitude,longitude,sd_east,sd_north,satellites\n,50,8,1,1,12\n",
                 "fixes.csv:2:1: a time in seconds is expected, not '(empty)'");
  expect_refused("latitude,longitude,sd_east,sd_north,time\n50,8,1,1\n",
                 "fixes.csv:2:9: a time in seconds is expected, not ''");
  expect_refused("pose,session,latitude,longitude,sd_east,sd_north\n1,4294967296,50,8,1,1\n",
                 "fixes.csv:2:3: a session is a number below 2^32");
  expect_refused(head + "1,50,8,1,1,1\n", "fixes.csv:2:12: ");
  expect_refused(head + "1,-90.5,8,1,1\n", "fixes.csv:2:3: an angle from -90 to 90 degrees is expected");
  expect_refused(head + "1,50,361,1,1\n", "fixes.csv:2:6: an angle from -360 to 360 degrees is expected");
  expect_refused(head + "1,50,8,1,2e6\n", "fixes.csv:2:10: a standard deviation is from 1e-6 to 1e6 m");
  expect_refused("time,latitude,longitude,height,sd_east,sd_north,sd_up\n1,50,8,1e9,1,1,1\n",
                 "fixes.csv:2:8: a height from -1e7");
}

}  // namespace
}  // namespace mapjoin
