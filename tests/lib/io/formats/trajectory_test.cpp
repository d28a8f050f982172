// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/formats/trajectory.hpp>
#include <mapjoin/io/open.hpp>
#include <numbers>
#include <string>
#include <tests/support/error_of.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class TrajectoryTest : public ::testing::Test {
 protected:
  template <int Dim>
  Log<Dim> read(const std::string& text) const {
    return std::get<Log<Dim>>(open_log(folder.file("some", text)).value());
  }
  std::string message(const std::string& text) const { return testing::error_of(open_log(folder.file("some", text))); }

  testing::TemporaryFolder folder;
};

TEST_F(TrajectoryTest, TumGivesTimesToTheNanosecond) {
  const auto log = read<3>(
      "# time x y z qx qy qz qw\n1305031102.175304123 1 2 3 0 0 0 1\n1305031103.5 4 5 6 1 0 0 0\n-0.25 0 0 1 0 0 0 1\n");
  EXPECT_THAT(log.poses, ElementsAre(PoseId{0, 0}, PoseId{0, 1}, PoseId{0, 2}));
  EXPECT_THAT(log.stamps_ns, ElementsAre(1305031102175304123, 1305031103500000000, -250000000));
  EXPECT_EQ(log.initial.poses[1].translation, Point<3>(4, 5, 6));
  EXPECT_EQ(log.initial.poses[1].rotation.quaternion().x(), 1.0);
}

/// Other programs write doubles, which are a little less or a little more than the time.
TEST_F(TrajectoryTest, TumGivesTimesToTheNearestNanosecond) {
  const auto log = read<3>(
      "12.000000000999999 1 2 3 0 0 0 1\n12.9999999996 4 5 6 0 0 0 1\n13.00000000149 4 5 6 0 0 0 1\n"
      "-0.0000000015 0 0 1 0 0 0 1\n");
  EXPECT_THAT(log.stamps_ns, ElementsAre(12'000'000'001, 13'000'000'000, 13'000'000'001, -2));
  EXPECT_THAT(message("-9223372036.8547758085 1 2 3 0 0 0 1\n"), HasSubstr("a time in seconds is expected"));
}

TEST_F(TrajectoryTest, TumTakesTimesWithAPlus) {
  EXPECT_THAT(read<3>("+1.5 1 2 3 0 0 0 1\n").stamps_ns, ElementsAre(1500000000));
  for (const std::string time : {"++1", "+-1", "1+"}) EXPECT_FALSE(nanoseconds(time)) << time;
}

TEST_F(TrajectoryTest, TumTakesTimesWithExponents) {
  EXPECT_THAT(read<3>("1.5e3 1 2 3 0 0 0 1\n").stamps_ns, ElementsAre(1500000000000));
  EXPECT_EQ(message("1e99 1 2 3 0 0 0 1\n").substr(message("1e99 1 2 3 0 0 0 1\n").find(":1:")),
            ":1:1: a time in seconds is expected, not '1e99'");
}

TEST_F(TrajectoryTest, TumThatCountsHasNoTimes) {
  EXPECT_THAT(read<3>("0 0 0 1 0 0 0 1\n1 0 0 1 0 0 0 1\n").stamps_ns, IsEmpty());
  EXPECT_THAT(read<3>("1 0 0 1 0 0 0 1\n2 0 0 1 0 0 0 1\n").stamps_ns, ElementsAre(1000000000, 2000000000));
}

TEST_F(TrajectoryTest, IsInThePlaneWhereEveryPoseIs) {
  const auto flat = read<2>("0 1 2 0 0 0 0.6 0.8\n1 3 4 0 0 0 0 1\n");
  EXPECT_EQ(flat.initial.poses[0].translation, Point<2>(1, 2));
  EXPECT_NEAR(flat.initial.poses[0].rotation.angle(), 2.0 * std::atan2(0.6, 0.8), 1e-15);
  EXPECT_EQ(read<3>("0 1 2 0 0 0 0.6 0.8\n1 3 4 0 0.6 0 0 0.8\n").poses.size(), 2u);
}

TEST_F(TrajectoryTest, KittiGivesTheRowsOfRotationAndTranslation) {
  const auto log = read<3>("1 0 0 7 0 0 -1 8 0 1 0 9\n");  // a quarter turn about x
  EXPECT_EQ(log.initial.poses[0].translation, Point<3>(7, 8, 9));
  const RotationVector<3> quarter(0.5 * std::numbers::pi, 0.0, 0.0);
  EXPECT_LE((log.initial.poses[0].rotation.log() - quarter).norm(), 1e-15);
  EXPECT_THAT(log.stamps_ns, IsEmpty());
  const auto flat = read<2>("0 -1 0 7 1 0 0 8 0 0 1 0\n");
  EXPECT_NEAR(flat.initial.poses[0].rotation.angle(), 0.5 * std::numbers::pi, 1e-15);
}

TEST_F(TrajectoryTest, KittiTakesRotationsOfThreeDigits) {
  const auto log = read<3>("1 0 0 7 0 0.707 -0.707 8 0 0.707 0.707 9\n");
  EXPECT_LE((log.initial.poses[0].rotation.log() - RotationVector<3>(0.25 * std::numbers::pi, 0.0, 0.0)).norm(), 1e-12);
}

TEST_F(TrajectoryTest, NamesThePlaceOfWhatIsWrong) {
  EXPECT_THAT(message("0 0 0 1 0 0 0 1\n1 0 0 1 0 0 0\n"), EndsWith(":2:14: the line ends where a number is expected"));
  EXPECT_THAT(message("0 0 0 1 0 0 0 1\n1 0 0 1 0 0 0 0\n"),
              EndsWith(":2:15: the four numbers up to here are not a unit quaternion"));
  EXPECT_THAT(message("1 0 0 7 0 0 1 8 0 1 0 9\n"), EndsWith("the first three columns up to here are not a rotation"));
  EXPECT_THAT(message("1 0.02 0 7 0 1 0 8 0 0 1 9\n"), EndsWith("the first three columns up to here are not a rotation"));
  EXPECT_THAT(message("1 0 0 7 0 0 nan 8 0 1 0 9\n"), HasSubstr(":1:1: no log format has lines that begin with '1'"));
  EXPECT_THAT(message("1 0 0\n"), HasSubstr(":1:1: no log format has lines that begin with '1'"));
}

}  // namespace
}  // namespace mapjoin
