// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <fstream>
#include <mapjoin/gps/geographic_frame.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <tests/apps/command.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/gps_world.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class GpsCommand : public ::testing::Test {
 protected:
  GpsCommand() { write_fixes(0); }
  /// Writes the log of a world and its fixes as a table, each by its pose; `spoiled` of them, from the second one on, are 50 m
  /// too far east.

  void write_fixes(std::size_t spoiled) {
    const auto world = gps_world<2>({.poses = 100, .between = 2, .deviation = 0.2});
    Log<2> bare = world.log;
    bare.graph.pose_factors.resize(bare.edges().size());
    EXPECT_TRUE(write_g2o(bare, log));
    const GeographicFrame frame({50.0, 8.0, 0.0});
    std::string text = "pose,latitude,longitude,sd_east,sd_north\n";
    std::size_t number = 0;
    for (const PoseFactor<2>& fix : world.log.pose_priors()) {
      const double east = number >= 1 && number <= spoiled ? 50.0 : 0.0;
      ++number;
      const auto& [x, y] = std::pair(fix.measured.translation.x() + east, fix.measured.translation.y());
      const GeographicPoint place = frame.to_geographic(Point<3>{x, y, 0.0});
      text += fmt::format("{},{},{},0.2,0.2\n", world.log.poses[fix.target].key, place.latitude, place.longitude);
    }
    folder.file("fixes.csv", text);
  }
  std::vector<std::string> command(const std::string& name, std::vector<std::string> further) const {
    std::vector<std::string> words = {name, log, "--gps", fixes, "--gps-lever", "3.8,0.5"};
    words.insert(words.end(), further.begin(), further.end());
    return words;
  }

  TemporaryFolder folder;
  std::string log = (folder.path() / "log.g2o").string();
  std::string fixes = (folder.path() / "fixes.csv").string();
  std::string out = (folder.path() / "out").string();
};

TEST_F(GpsCommand, TheMapStandsOnTheEarth) {
  const auto report = report_of(command("run", {"-o", out}));
  EXPECT_EQ(report["gps"]["fixes"], 50);
  EXPECT_EQ(report["gps"]["left_out"], 0);
  EXPECT_EQ(report["gps"]["lever"], nlohmann::json({3.8, 0.5, 0.0}));
  EXPECT_NEAR(report["gps"]["origin"]["latitude"].get<double>(), 50.0, 1e-2);
  EXPECT_TRUE(report["gauge"]["held_poses"].empty());
  EXPECT_EQ(report["verdict"], "fits");
  EXPECT_THAT(bytes_of(out + "/poses.geographic.csv"), StartsWith("pose,latitude,longitude\n0,"));
  const auto geojson = nlohmann::json::parse(bytes_of(out + "/map.geojson"));
  EXPECT_EQ(geojson["type"], "FeatureCollection");
  const auto& line = geojson["features"][0]["geometry"];
  EXPECT_EQ(line["type"], "LineString");
  ASSERT_EQ(line["coordinates"].size(), 100U);
  EXPECT_NEAR(line["coordinates"][0][0].get<double>(), 8.0, 1e-2) << "the longitude comes first";
  EXPECT_NEAR(line["coordinates"][0][1].get<double>(), 50.0, 1e-2);
  EXPECT_EQ(geojson["features"].size(), 1 + report["features"].get<std::size_t>());
  EXPECT_EQ(geojson["features"][1]["geometry"]["type"], "Point");
}

TEST_F(GpsCommand, TheMapCanBeSolvedAgainFromItsFile) {
  const auto report = report_of(command("run", {"-o", out}));
  const auto again = report_of({"solve", out + "/map.g2o"});
  EXPECT_EQ(again["priors"], 50);
  EXPECT_NEAR(again["chi2"].get<double>(), report["chi2"].get<double>(), 1e-6 * report["chi2"].get<double>());
}

TEST_F(GpsCommand, SolveWritesTheSameBesideItsMap) {
  const std::string map = (folder.path() / "map.g2o").string();
  const auto report = report_of(command("solve", {"-o", map}));
  EXPECT_EQ(report["files"].size(), 3U);
  EXPECT_THAT(bytes_of(folder.path() / "map.geographic.csv"), StartsWith("pose,latitude,longitude\n"));
  EXPECT_THAT(bytes_of(folder.path() / "map.geojson"), StartsWith("{\"type\":\"FeatureCollection\""));
}

TEST_F(GpsCommand, RobustLeavesOutWrongFixesByTheirLine) {
  write_fixes(8);
  const auto report = report_of(command("run", {"-o", out, "--robust"}));
  EXPECT_EQ(report["robust"]["fixes"], 8);
  EXPECT_EQ(report["gps"]["rejected"], 8);
  EXPECT_EQ(report["priors"], 50) << "the input is counted as it was before --robust";
  EXPECT_EQ(report["verdict"], "fits");
  EXPECT_THAT(bytes_of(out + "/rejected.csv"), HasSubstr("\nfix,3,2,"));
  EXPECT_THAT(bytes_of(out + "/inliers.g2o"), HasSubstr("EDGE_PRIOR_SE2 "));
}

TEST_F(GpsCommand, RobustTakesSessionsThatOnlyFixesTie) {
  write_fixes(8);
  std::string text = "session,";
  for (const std::string& line : lines_of(bytes_of(fixes))) {
    text += text.ends_with("session,") ? line + "\n" : fmt::format("0,{0}\n1,{0}\n", line);
  }
  const std::string both = folder.file("both.csv", text).string();
  const std::string other = folder.file("other.g2o", bytes_of(log)).string();
  const auto report = report_of({"run", log, other, "--features", "own", "--keep-copies", "--gps", both, "--gps-lever",
                                 "3.8,0.5", "--robust", "-o", out});
  EXPECT_EQ(report["sessions"], 2);
  EXPECT_EQ(report["gps"]["rejected"], 16);
  EXPECT_EQ(report["verdict"], "fits");
  EXPECT_TRUE(report["gauge"]["held_poses"].empty());
}

TEST_F(GpsCommand, AFixThatIsOutOfLineIsNamedByItsLine) {
  write_fixes(1);
  std::ofstream(log, std::ios::app) << "FIX 0\n";
  const std::string out = call(command("run", {})).out;
  EXPECT_THAT(out, HasSubstr("MISFIT: fix of line 3 at pose 2 (chi2 "));
  EXPECT_THAT(out, HasSubstr("left out: fixed poses, for the fixes hold the map (1)\n"));
  EXPECT_EQ(report_of(command("run", {}))["misfits"][0]["lines"], nlohmann::json::array({3}));
}

TEST_F(GpsCommand, FixesAtTooFewPosesAreNamedByTheirFile) {
  const auto first = lines_of(bytes_of(fixes));
  const auto lone = folder.file("lone.csv", first[0] + "\n" + first[1] + "\n" + first[1] + "\n").string();
  expect_failure(call({"run", log, "--gps", lone}), 3,
                 "lone.csv: has fixes at 1 pose of " + log +
                     ", about which the map could turn: it takes fixes at 2 different places at least");
}

TEST_F(GpsCommand, SaysWhatDoesNotGoTogether) {
  EXPECT_THAT(call({"run", log, "--gps-lever", "1,2"}).err, HasSubstr("--gps-lever is of --gps"));
  EXPECT_THAT(call({"run", log, "--gps", fixes, "--gps-lever", "1"}).err, HasSubstr("not two or three numbers"));
  EXPECT_THAT(call(command("run", {"--follow"})).err, HasSubstr("--follow is for one log in g2o, without --stamps, --gps"));
  EXPECT_THAT(call(command("run", {"--parts", "all", "-o", out})).err, HasSubstr("--parts all makes maps that nothing ties"));
  const auto timed = folder.file("timed.csv", "time,latitude,longitude,sd_east,sd_north\n1,50,8,1,1\n").string();
  const Ended ended = call({"run", log, "--gps", timed});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, HasSubstr("timed.csv: its fixes have times, and the poses of " + log + " have none"));
}

}  // namespace
}  // namespace mapjoin::testing
