// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/mrclam/mrclam.hpp>
#include <mapjoin/io/open.hpp>
#include <numbers>
#include <tests/support/data.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/temporary_folder.hpp>
#include <vector>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

/// A robot that drives a quarter circle of radius 2 in a second, stands for a second, and goes straight for a second.
class MrclamTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder.file("Barcodes.dat", "# Subject  Barcode\n1 5\n2 14\n6 72\n7 27\n");
    folder.file("Robot1_Odometry.dat", "# Time v w\n100.0 3.141592653589793 1.5707963267948966\n101.0 0 0\n102 1 0\n");
    folder.file("Robot1_Measurement.dat",
                "# Time Subject range bearing\n99 72 1 0\n101.0 72 2 0\n101.0 27 3 1.5707963267948966\n103 14 1 0\n"
                "103 72 4 0\n103.5 99 1 0\n");
  }
  Log<2> read() const { return std::get<Log<2>>(open_log(folder.path()).value()); }
  std::string message() const { return testing::error_of(open_log(folder.path())); }

  testing::TemporaryFolder folder;
};

TEST_F(MrclamTest, IntegratesVelocitiesAlongArcs) {
  const Log<2> log = read();
  ASSERT_EQ(log.odometry().size(), 2u);
  EXPECT_LE((log.odometry()[0].measured.translation - Point<2>(2, 2)).norm(), 1e-12);
  EXPECT_NEAR(log.odometry()[0].measured.rotation.angle(), 0.5 * kPi, 1e-12);
  EXPECT_LE((log.odometry()[1].measured.translation - Point<2>(1, 0)).norm(), 1e-12);
  EXPECT_THAT(log.stamps_ns, ElementsAre(100'000'000'000, 101'000'000'000, 103'000'000'000));
}

TEST_F(MrclamTest, TurnsRangesAndBearingsToPositions) {
  const Log<2> log = read();
  EXPECT_THAT(log.features, ElementsAre(FeatureId{6}, FeatureId{7}));
  ASSERT_EQ(log.observations().size(), 3u);
  EXPECT_EQ(log.observations()[0].measured, Point<2>(2, 0));
  EXPECT_LE((log.observations()[1].measured - Point<2>(0, 3)).norm(), 1e-12);
  const MrclamNoise noise;
  const double across = 2.0 * noise.bearing;
  const Matrix<2> P = Vector<2>(noise.range * noise.range, across * across).asDiagonal();
  EXPECT_TRUE(log.observations()[0].information.isApprox(Matrix<2>(P.inverse()), 1e-12));
}

TEST_F(MrclamTest, GivesMotionTheNoiseOfItsTime) {
  const Log<2> log = read();
  const MrclamNoise noise;
  // One second at rest and one straight ahead: the error of the heading moves the robot in the latter alone.
  const Matrix<3> P = log.odometry()[1].information.inverse();
  EXPECT_NEAR(P(0, 0), 2.0 * noise.forward * noise.forward, 1e-12);
  EXPECT_NEAR(P(2, 2), 2.0 * noise.turn * noise.turn, 1e-12);
  EXPECT_NEAR(P(1, 2), noise.turn * noise.turn, 1e-12);  // one second of turning error before one metre
}

TEST_F(MrclamTest, LeavesOutUnknownRobotsAndBarcodesAndWhatCameTooEarly) {
  const Log<2> log = read();
  EXPECT_EQ(log.unassociated, 1);
  EXPECT_EQ(log.skipped,
            (SkipCounts{{"sightings before the first odometry", 1}, {"sightings of robots that are not in the folder", 1}}));
}

TEST_F(MrclamTest, IsASessionPerRobot) {
  folder.file("Robot3_Odometry.dat", "1 0 0\n");
  folder.file("Robot3_Measurement.dat", "2 72 4 0\n");
  const Log<2> log = read();
  EXPECT_EQ(log.sessions.size(), 2u);
  EXPECT_EQ(log.poses.back(), (PoseId{2, 1}));
}

TEST_F(MrclamTest, TiesRobotsThatSeeEachOther) {
  folder.file("Robot2_Odometry.dat", "100 0 0\n");
  folder.file("Robot2_Measurement.dat", "101 27 3 0\n99 5 1 0\n102 5 2 0\n");
  const Log<2> log = read();
  EXPECT_THAT(log.poses, ElementsAre(PoseId{0, 0}, PoseId{0, 1}, PoseId{0, 2}, PoseId{0, 3}, PoseId{1, 0}, PoseId{1, 1},
                                     PoseId{1, 2}, PoseId{1, 3}));
  EXPECT_THAT(log.stamps_ns, ElementsAre(100'000'000'000, 101'000'000'000, 102'000'000'000, 103'000'000'000, 100'000'000'000,
                                         101'000'000'000, 102'000'000'000, 103'000'000'000));
  ASSERT_EQ(log.closures().size(), 2u);
  const PoseFactor<2>& by_first = log.closures()[0];
  EXPECT_EQ(log.poses[by_first.base], (PoseId{0, 3}));
  EXPECT_EQ(log.poses[by_first.target], (PoseId{1, 3}));
  EXPECT_EQ(by_first.measured.translation, Point<2>(1, 0));
  const MrclamNoise noise;
  const Vector<3> weights(1.0 / (noise.range * noise.range), 1.0 / (noise.bearing * noise.bearing), 0.0);
  EXPECT_TRUE(by_first.information.isApprox(Matrix<3>(weights.asDiagonal()), 1e-12)) << "nothing is said of the heading";
  EXPECT_EQ(log.poses[log.closures()[1].base], (PoseId{1, 2}));
  EXPECT_EQ(log.unassociated, 1) << "an unknown barcode";
  EXPECT_EQ(log.skipped, (SkipCounts{{"sightings before the first odometry", 2}}));
}

TEST_F(MrclamTest, IsALogThoughItIsAFolder) {
  EXPECT_FALSE(may_hold_maps(folder.path()));
}

TEST_F(MrclamTest, GoesAlongArcsThatAreAlmostStraight) {
  folder.file("Robot1_Odometry.dat", "100 1 0.5\n101 0 0\n");
  const Pose<2> step = read().odometry()[0].measured;
  EXPECT_LE((step.translation - 2.0 * Point<2>(std::sin(0.5), 1.0 - std::cos(0.5))).norm(), 1e-12);
}

TEST_F(MrclamTest, IsOnePoseWhatIsSeenWithinATenthOfAMillisecond) {
  folder.file("Robot1_Measurement.dat", "101 72 2 0\n101.00005 27 2 0\n101.01 72 2 0\n");
  EXPECT_EQ(read().poses.size(), 3u);
}

TEST_F(MrclamTest, NoRobotSeesItself) {
  folder.file("Robot1_Measurement.dat", "101 5 2 0\n102 72 2 0\n");
  const Log<2> log = read();
  EXPECT_EQ(log.unassociated, 1);
  EXPECT_TRUE(log.closures().empty());
}

TEST_F(MrclamTest, TakesFastVehiclesThatSeeFarLongAfter1970) {
  folder.file("Robot1_Odometry.dat", "8.9e9 9e4 0\n");
  folder.file("Robot1_Measurement.dat", "8900000000.01 72 9e5 0\n");
  EXPECT_EQ(message(), "");
  folder.file("Robot1_Odometry.dat", "9.1e9 1 0\n");
  EXPECT_THAT(message(), EndsWith("Robot1_Odometry.dat:1:1: a time must be below 9e9 s"));
}

TEST_F(MrclamTest, NamesThePlaceOfWhatIsWrong) {
  folder.file("Robot1_Measurement.dat", "101 72 2\n");
  EXPECT_THAT(message(), EndsWith("Robot1_Measurement.dat:1:9: the line ends where a number is expected"));
  folder.file("Robot1_Measurement.dat", "101 72 -2 0\n");
  EXPECT_THAT(message(), EndsWith("Robot1_Measurement.dat:1:8: a range must be from 1e-6 to 1e6 m"));
  folder.file("Robot1_Measurement.dat", "101 72 9e-7 0\n");
  EXPECT_THAT(message(), EndsWith("Robot1_Measurement.dat:1:8: a range must be from 1e-6 to 1e6 m"));
  folder.file("Robot1_Measurement.dat", "101 72 2e-6 0\n");
  EXPECT_EQ(message(), "");
  folder.file("Robot1_Measurement.dat", "101 72 1e7 0\n");
  EXPECT_THAT(message(), EndsWith("Robot1_Measurement.dat:1:8: a range must be from 1e-6 to 1e6 m"));
  folder.file("Robot1_Odometry.dat", "101 1e7 0\n");
  EXPECT_THAT(message(), HasSubstr("a velocity must be below 1e6 m/s or rad/s"));
  folder.file("Robot1_Odometry.dat", "101 nan 0\n");
  EXPECT_THAT(message(), EndsWith("Robot1_Odometry.dat:1:5: 'nan' stands where a number is expected"));
  folder.file("Barcodes.dat", "1 5\n2 5\n");
  EXPECT_THAT(message(), EndsWith("Barcodes.dat:2:3: this barcode is there a second time"));
  for (const char* name : {"Robot1_Odometry.dat", "Robot1_Measurement.dat"}) std::filesystem::remove(folder.path() / name);
  folder.file("Barcodes.dat", "1 5\n");
  EXPECT_THAT(message(), EndsWith(": the log has no poses"));
}

TEST_F(MrclamTest, NeedsBothFilesOfARobot) {
  folder.file("Robot3_Measurement.dat", "2 72 4 0\n");
  EXPECT_THAT(message(), EndsWith("Robot3_Odometry.dat: No such file or directory"));
}

TEST_F(MrclamTest, RefusesAFileThatIsThereTwice) {
  folder.file("Robot1_Odometry.dat.gz", "");
  EXPECT_THAT(message(), EndsWith("Robot1_Odometry.dat: is there twice, packed and unpacked; remove one"));
}

/// The lines of a table: the numbers after the first one, by the first one.
template <int Size>
std::map<double, Vector<Size>> table_in(const std::filesystem::path& path) {
  const auto bytes = FileBytes::read(path).value();
  std::map<double, Vector<Size>> table;
  for (TextScanner text(path.string(), bytes.view()); text.next_line();) {
    const double key = text.number();
    table[key] = text.vector<Size>();
  }
  return table;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values.at(values.size() / 2);
}

TEST(MrclamData, AgreesWithTheMotionCapture) {
  const auto folder = testing::data_file("mrclam6");
  const Log<2> log = std::get<Log<2>>(read_mrclam(folder).value());
  EXPECT_EQ(log.sessions.size(), 5u);
  EXPECT_EQ(log.observations().size(), 1534u + 3239u + 4348u + 2023u + 4239u);
  EXPECT_EQ(log.closures().size(), 407u + 792u + 1277u + 373u + 1139u - 7u)
      << "seven before the first odometry of the robot seen";
  EXPECT_EQ(log.unassociated, 1 + 0 + 2 + 3 + 0);
  EXPECT_EQ(log.skipped, (SkipCounts{{"sightings before the first odometry", 7}}));

  const auto landmarks = table_in<2>(folder / "Landmark_Groundtruth.dat");
  const auto truth = table_in<3>(folder / "Robot1_Groundtruth.dat.gz");
  const auto true_pose = [&](PoseIndex p) {
    const auto at = truth.lower_bound(1e-9 * static_cast<double>(log.stamps_ns[p]));
    const Vector<3> v = at == truth.end() ? truth.rbegin()->second : at->second;
    return Pose<2>{v.head<2>(), Rotation<2>(v[2])};
  };
  const auto is_first_robot = [&](PoseIndex p) { return log.poses[p].session == 0; };
  std::vector<double> misses;
  for (const auto& o : log.observations()) {
    if (!is_first_robot(o.base)) continue;
    const auto subject = static_cast<double>(log.features[o.target].key);
    misses.push_back((transform(true_pose(o.base), o.measured) - landmarks.at(subject)).norm());
  }
  EXPECT_EQ(misses.size(), 1534u);
  EXPECT_LT(median(misses), 0.2);
  std::vector<double> drifts;
  for (const auto& edge : log.odometry()) {
    if (!is_first_robot(edge.base)) continue;
    drifts.push_back(local(between(true_pose(edge.base), true_pose(edge.target)), edge.measured).norm());
  }
  EXPECT_LT(median(drifts), 0.02);
}

}  // namespace
}  // namespace mapjoin
