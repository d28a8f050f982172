// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/formats/pose_tables.hpp>
#include <mapjoin/io/open.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/random.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

template <typename D>
class PoseCsvTest : public ::testing::Test {};
TYPED_TEST_SUITE(PoseCsvTest, Dimensions);

TYPED_TEST(PoseCsvTest, BringsBackWhatWriteCsvWrote) {
  constexpr int kDim = TypeParam::value;
  const TemporaryFolder folder;
  Random random;
  GlobalMap<kDim> map;
  map.pose_ids = {{0, 6989586621679009792u}, {0, 6989586621679009793u}, {1, 7}};
  for (int k = 0; k < 3; ++k) map.poses.push_back(random.pose<kDim>());
  map.stamps_ns = {1, 2, 3};
  map.pose_covariances = Table<PoseIndex, PoseMatrix<kDim>>(3, PoseMatrix<kDim>::Identity());
  const auto path = folder.path() / "poses.csv";
  ASSERT_TRUE(write_csv(map, path, folder.path() / "features.csv"));
  EXPECT_THAT(content_of(path), HasSubstr("\n0,a0,"));
  const auto log = std::get<Log<kDim>>(open_log(path).value());
  EXPECT_EQ(log.poses, map.pose_ids);
  EXPECT_EQ(log.stamps_ns, map.stamps_ns);
  for (const PoseIndex p : indices(map.poses)) {
    EXPECT_EQ(log.initial.poses[p].translation, map.poses[p].translation);
    EXPECT_EQ(log.initial.poses[p].rotation.matrix(), map.poses[p].rotation.matrix());
  }
}

TEST(PoseCsv, KeepsTheOrderOfTheTable) {
  const TemporaryFolder folder;
  const auto path = folder.file("poses.csv", "pose,x,y,phi,stamp_ns\n0,0,0,0,5\n2,1,0,0,6\n1,2,0,0,7\n");
  const auto log = std::get<Log<2>>(open_log(path).value());
  EXPECT_EQ(log.poses, PoseIds({{0, 0}, {0, 2}, {0, 1}}));
  EXPECT_THAT(log.stamps_ns, ElementsAre(5, 6, 7));
  EXPECT_EQ(log.initial.poses[PoseIndex(1)].translation, Point<2>(1, 0));
}

TEST(PoseCsv, NamesThePlaceOfWhatIsWrong) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& text) { return open_log(folder.file("map.csv", text)).error().message; };
  EXPECT_THAT(message("pose,x,y\n1,2,3\n"), EndsWith("map.csv:1: does not name the columns pose and, side by side, x,y,phi"));
  EXPECT_THAT(message("pose,x,y,z\n1,2,3,4\n"),
              EndsWith("does not name the columns pose and, side by side, x,y,z,qx,qy,qz,qw"));
  EXPECT_THAT(message("pose,x,y,name,phi\n"), EndsWith("map.csv:1: does not name the columns pose and, side by side, x,y,phi"));
  EXPECT_THAT(message("# a map\n\npose,x,y,phi,x\n1,2,3,0,4\n"), EndsWith("map.csv:3: names the column x more than once"));
  EXPECT_THAT(message("pose,x,y,phi\n1,2,3\n"), EndsWith(":2:6: the line ends where a number is expected"));
  EXPECT_THAT(message("pose,x,y,phi\n1,2,3,0\n-1,2,3,0\n"), EndsWith(":3:1: '-1' stands where an id is expected"));
  EXPECT_THAT(message("pose,x,y,phi\n1,,3,0\n"), EndsWith(":2:3: '(empty)' stands where a number is expected"));
  EXPECT_THAT(message("pose,x,y,phi\n1,2,3,\r\n"), EndsWith(":2:7: '(empty)' stands where a number is expected"));
  EXPECT_THAT(message("session,pose,x,y,phi\n4294967296,1,2,3,0\n"), EndsWith(":2:1: a session is a number below 2^32"));
  EXPECT_THAT(message("pose,x,y,phi\n1,2,3,0\n1,2,3,0\n"), EndsWith("map.csv:3:7: pose 1 has a line before this one"));
}

TEST(PoseCsv, BlanksAroundTheNamesOfColumnsDoNotCount) {
  const TemporaryFolder folder;
  const auto log = std::get<Log<2>>(open_log(folder.file("poses.csv", "pose, x , y, phi\n4, 1, 2, 0\n")).value());
  EXPECT_EQ(log.initial.poses[PoseIndex(0)].translation, Point<2>(1.0, 2.0));
}

TEST(PoseCsv, PassesOverOtherColumnsWhateverTheirNamesAndWords) {
  const TemporaryFolder folder;
  const auto plane = folder.file("plane.csv", "day,pose,x,y,phi,z,y\n1 May 2024,5,1,2,3,7,8\n");
  EXPECT_EQ(std::get<Log<2>>(open_log(plane).value()).initial.poses[0].translation, Point<2>(1, 2));
  const auto space = folder.file("space.csv", "pose,phi,x,y,z,qx,qy,qz,qw\n5,9,1,2,3,0,0,0,1\n");
  EXPECT_EQ(std::get<Log<3>>(open_log(space).value()).initial.poses[0].translation, Point<3>(1, 2, 3));
}

TEST(PoseCsv, PassesOverCellsThatAreEmpty) {
  const TemporaryFolder folder;
  for (const std::string table : {"pose,note,x,y,phi,more,note\n5,,1,2,3, ,\n6,seen,4,5,6,,\n",
                                  "note,pose,x,y,phi\n,5,1,2,3\r\n\t,6,4,5,6\n\n", "pose,x,y,phi,note\n5,1,2,3,\n6,4,5,6,"}) {
    const auto log = std::get<Log<2>>(open_log(folder.file("map.csv", table)).value());
    EXPECT_EQ(log.initial.poses[0].translation, Point<2>(1, 2));
    EXPECT_EQ(log.initial.poses[1].translation, Point<2>(4, 5));
  }
}

class StampsTest : public ::testing::Test {
 protected:
  std::string message(const std::string& stamps) {
    auto log = this->log;
    return testing::error_of(read_stamps(folder.file("stamps", stamps), log));
  }
  TemporaryFolder folder;
  Log<2> log = std::get<Log<2>>(open_log(folder.file("log", "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n")).value());
};

TEST_F(StampsTest, AreTakenByIdBehindAHeaderToTheNanosecond) {
  for (const std::string text :
       {"id,time\n2,1600000000.000000001\n7,3\n1,0.5,more\n", "# id time\n1 0.5\n2 1600000000.000000001\n"}) {
    ASSERT_TRUE(read_stamps(folder.file("stamps", text), log));
    EXPECT_THAT(log.stamps_ns, ElementsAre(500'000'000, 1'600'000'000'000'000'001));
  }
  ASSERT_TRUE(take_ids_as_stamps(log));
  EXPECT_THAT(log.stamps_ns, ElementsAre(1, 2));
  log.poses[PoseIndex(1)].key = std::uint64_t{1} << 63;
  EXPECT_THAT(testing::error_of(take_ids_as_stamps(log)),
              EndsWith("the id of pose 9223372036854775808 is no time: 2^63 ns or more; --stamps gives times"));
  log.poses[PoseIndex(1)].key = *parse_key("x3");
  EXPECT_THAT(testing::error_of(take_ids_as_stamps(log)),
              EndsWith("the id of pose x3 is no time: it is a GTSAM symbol; --stamps gives times"));
  EXPECT_THAT(log.stamps_ns, ElementsAre(1, 2));
}

TEST_F(StampsTest, AreRefusedWhereTheyDoNotFit) {
  EXPECT_THAT(message("1 1\n"), EndsWith("stamps: has no time for pose 2; every pose takes one"));
  EXPECT_THAT(message("1 1\n2 2\n1 1\n"), EndsWith(":3:1: pose 1 has two times; keep one"));
  EXPECT_THAT(message("1 1\nx 2\n"), EndsWith(":2:1: 'x' stands where an id is expected"));
  EXPECT_THAT(message("1 noon\n"), EndsWith(":1:3: a time in seconds is expected, not 'noon'"));
  EXPECT_THAT(message("1 1403636579763555584\n"),
              EndsWith("not '1403636579763555584', which is too large for seconds: divide what is in smaller units"));
  EXPECT_THAT(message("1 1\n2\n"), EndsWith(":2:2: a time in seconds is expected, not ''"));
  for (const std::string no_time : {".", "-", "-."}) {
    EXPECT_THAT(message("1 " + no_time + "\n"), EndsWith(":1:3: a time in seconds is expected, not '" + no_time + "'"));
  }
  log.poses[PoseIndex(1)] = {1, 1};
  EXPECT_THAT(message("1 1\n"),
              HasSubstr(":1:1: several sessions have a pose 1; stamp each log by itself, by `mapjoin run LOG"));
}

}  // namespace
}  // namespace mapjoin::testing
