// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

/// Three poses in a row, the last one half a metre off, and the true ones.
const std::string kMap = "VERTEX_SE2 4 0 0 0\nVERTEX_SE2 5 1 0 0\nVERTEX_SE2 6 2 0.5 0\n";
const std::string kTrueMap = "VERTEX_SE2 4 0 0 0\nVERTEX_SE2 5 1 0 0\nVERTEX_SE2 6 2 0 0\nEDGE_SE2 4 6 2 0 0 1 0 0 1 0 1\n";

class ErrorCommand : public ::testing::Test {
 protected:
  nlohmann::json errors(std::vector<std::string> arguments) { return report_of(std::move(arguments))["errors"]; }

  TemporaryFolder folder;
  std::string map = folder.file("map.g2o", kMap).string();
  std::string truth = folder.file("truth.g2o", kTrueMap).string();
};

TEST_F(ErrorCommand, MeasuresAbsoluteAndRelativeErrorsAndRelations) {
  const auto none = errors({"error", map, truth, "--align", "none", "--spans", "1,2"});
  EXPECT_NEAR(none["ate"]["translation"]["rms"], 0.5 / std::sqrt(3.0), 1e-12);
  EXPECT_EQ(none["ate"]["translation"]["median"], 0.0);
  EXPECT_EQ(none["rpe"][0]["translation"]["max"], 0.5);
  EXPECT_EQ(none["rpe"][1]["translation"]["count"], 1);
  EXPECT_EQ(none["relations"]["translation"]["rms"], 0.5) << "between the poses that the truth's edge ties";
  EXPECT_LT(errors({"error", map, truth})["ate"]["translation"]["rms"], 0.2);
  EXPECT_EQ(errors({"error", map, truth, "--spans", "1.5", "--span-unit", "metres"})["rpe"][0]["translation"]["count"], 0);
}

TEST_F(ErrorCommand, TakesTrajectoriesAndTables) {
  const std::string tum = folder.file("a.txt", "10.001 0 0 0 0 0 0 1\n11.004 1 0 0 0 0 0 1\n12.5 2 0 0 0 0 0 1\n").string();
  const std::string csv = folder.file("b.csv", "pose,x,y,phi,stamp_ns\n4,0,0,0,10000000000\n5,1,0,0,11000000000\n").string();
  EXPECT_EQ(errors({"error", csv, tum})["ate"]["translation"]["count"], 2) << "times to a hundredth of a second";
  EXPECT_EQ(errors({"error", csv, tum, "--max-time-difference", "0.002"})["ate"]["translation"]["count"], 1);
  EXPECT_EQ(errors({"error", csv, truth})["ate"]["translation"]["count"], 2) << "by their names";
  const std::string kitti = folder.file("c.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n").string();
  EXPECT_EQ(errors({"error", map, kitti})["ate"]["translation"]["count"], 2) << "by their count";
}

TEST_F(ErrorCommand, FindsThePosesOfATrajectoryInATruthWithNamesByTimeElseByCount) {
  const std::string table =
      folder
          .file("truth.csv",
                "pose,x,y,phi,stamp_ns\n0,0,0,0,10000000000\n1,1,0,0,11000000000\n2,2,7,0,12000000000\n3,3,0,0,13000000000\n")
          .string();
  const std::string some = folder.file("some.tum", "11 1 0 0 0 0 0 1\n13 3 0 0 0 0 0 1\n").string();
  const auto timed = errors({"error", some, table, "--align", "none"})["ate"]["translation"];
  EXPECT_EQ(timed["count"], 2);
  EXPECT_EQ(timed["max"], 0.0) << "poses 1 and 3, not 0 and 1";
  const std::string kitti = folder.file("c.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n");
  const std::string named = folder.file("named.g2o", kTrueMap + "EDGE_SE2 4 5 1 0 0 1 0 0 1 0 1\n").string();
  const auto counted = errors({"error", kitti, named, "--align", "none"});
  EXPECT_EQ(counted["ate"]["translation"]["count"], 3) << "poses 4, 5 and 6";
  EXPECT_EQ(counted["relations"]["translation"]["count"], 2);
  EXPECT_EQ(counted["relations"]["translation"]["max"], 0.0);
  const std::string two = folder.file("two.csv",
                                      "session,pose,x,y,phi,stamp_ns\n0,0,0,0,0,10000000000\n0,1,1,0,0,12000000000\n"
                                      "1,0,9,0,0,11000000000\n1,1,9,0,0,13000000000\n");
  EXPECT_THAT(call({"error", some, two}).err, AllOf(HasSubstr("two.csv: sessions 1 and 0 are both under way at 11.000 s"),
                                                    HasSubstr("the folder of the run, in place of its trajectory, does")));
  EXPECT_THAT(call({"error", some, named}).err,
              HasSubstr("named.g2o: has no times by which to find the 2 poses of the map among its 3"));
}

TEST_F(ErrorCommand, CountsThePosesOfATrajectoryWithoutTimesAlsoForAMapWithTimes) {
  const std::string log = folder.file("drive.g2o", kSmallLog).string();
  const std::string stamps = folder.file("stamps.txt", "0 1\n1 1.5\n2 2\n").string();
  const std::string timed = (folder.path() / "timed").string();
  const std::string counted = (folder.path() / "counted").string();
  const std::string kitti = (folder.path() / "c.kitti").string();
  ASSERT_EQ(call({"run", log, "--stamps", stamps, "-o", timed, "--quiet"}).exit_code, 0);
  ASSERT_EQ(call({"run", log, "-o", counted, "--quiet"}).exit_code, 0);
  ASSERT_EQ(call({"convert", timed + "/trajectory.tum", kitti, "--quiet"}).exit_code, 0);
  for (const std::string& truth : {kitti, counted + "/trajectory.tum"}) {
    for (const auto& of_map : {errors({"error", timed, truth}), errors({"run", log, "--stamps", stamps, "--truth", truth})}) {
      EXPECT_EQ(of_map["ate"]["translation"]["count"], 3) << truth;
      EXPECT_LT(of_map["ate"]["translation"]["max"], 1e-9) << truth;
    }
  }
}

TEST_F(ErrorCommand, TakesTheFolderOfARun) {
  const std::string run = (folder.path() / "run").string();
  ASSERT_EQ(call({"run", folder.file("drive.g2o", kSmallLog).string(), "-o", run, "--quiet"}).exit_code, 0);
  EXPECT_EQ(errors({"error", run, run + "/map.g2o"})["ate"]["translation"]["count"], 3);
  EXPECT_LT(errors({"error", run + "/map.g2o", run})["ate"]["translation"]["max"], 1e-9);
}

TEST_F(ErrorCommand, KnowsThePosesInTheFolderOfARunByTheNamesOfItsLogs) {
  const std::string run = (folder.path() / "run").string();
  const std::string text = kSmallLog + "EDGE_SE2_XY 0 8 3 -2 1 0 1\n";
  const std::string one = folder.file("one.g2o", text).string();
  const std::string two = folder.file("two.g2o", text).string();
  ASSERT_EQ(call({"run", one, two, "--features", "shared", "--keep-copies", "-o", run, "--quiet"}).exit_code, 0);
  EXPECT_EQ(errors({"error", run, run + "/poses.csv"})["ate"]["translation"]["count"], 6);
  EXPECT_EQ(errors({"error", run + "/poses.csv", run})["ate"]["translation"]["count"], 6);
  const auto again = errors({"run", one, two, "--features", "shared", "--keep-copies", "-o", run + ".g2o", "--truth", run});
  EXPECT_EQ(again["ate"]["translation"]["count"], 6);
}

TEST_F(ErrorCommand, KnowsTheTimesInTheFolderOfARun) {
  const std::string run = (folder.path() / "run").string();
  const std::string log = folder.file("drive.g2o", kSmallLog).string();
  const std::string stamps = folder.file("stamps.txt", "0 10.5\n1 11.5\n2 12.5\n").string();
  ASSERT_EQ(call({"run", log, "--stamps", stamps, "-o", run, "--quiet"}).exit_code, 0);
  EXPECT_EQ(errors({"error", run, run + "/trajectory.tum"})["ate"]["translation"]["count"], 3);
}

TEST_F(ErrorCommand, SaysWhatDoesNotFit) {
  const Ended none = call({"error", map, folder.file("other.g2o", "VERTEX_SE2 9 0 0 0\n").string()});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("other.g2o: has no pose of the map, neither by name nor by count; where it has times"));
  const std::string table = folder.file("table.csv", "pose,x,y,phi,stamp_ns\n4,0,0,0,10000000000\n").string();
  EXPECT_THAT(call({"error", table, folder.file("late.tum", "20.5 0 0 0 0 0 0 1\n").string()}).err,
              HasSubstr("late.tum: has no pose of the map, neither by name nor by time; --max-time-difference widens"));
  EXPECT_THAT(call({"error", folder.file("log.g2o", kSmallLog).string(), truth}).err, HasSubstr("a map is expected"));
  EXPECT_EQ(call({"error", map, truth, "--spans", "1.5"}).exit_code, 2);
  const std::string timed = folder.file("timed.tum", "0 0 0 0 0 0 0 1\n0.1 1 0 0 0 0 0 1\n").string();
  const Ended no_times = call({"error", map, timed});
  EXPECT_EQ(no_times.exit_code, 2);
  EXPECT_THAT(no_times.err,
              HasSubstr("timed.tum: has times, and the poses of the map have none; `mapjoin run LOG --stamps FILE` gives "
                        "them, and its folder keeps them\n"));
  const std::string whole = folder.file("whole.tum", "0.000 0 0 0 0 0 0 1\n1.000 1 0 0 0 0 0 1\n").string();
  EXPECT_THAT(call({"error", map, whole}).err, HasSubstr("whole.tum: has times")) << "of whole seconds, not counts";
  const std::string kitti = folder.file("c.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n").string();
  EXPECT_THAT(call({"error", kitti, timed}).err, HasSubstr("have none; a TUM file or a table with times has them\n"));
  const std::string out = (folder.path() / "out").string();
  EXPECT_THAT(call({"run", folder.file("drive.g2o", kSmallLog).string(), "-o", out, "--truth", timed}).err,
              HasSubstr("timed.tum: has times"));
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_THAT(call({"error", map, truth, "--report", truth}).err, HasSubstr("TRUTH and --report are one file"));
}

TEST_F(ErrorCommand, RefusesTheTrajectoryOfOneOfSessionsThatAreUnderWayAtOnce) {
  const auto of_second = [&](const std::string& name, int begin) {
    std::string text = "session,pose,x,y,phi,stamp_ns\n0,0,0,0,0,10000000000\n0,1,1,0,0,11000000000\n0,2,2,0,0,12000000000\n";
    for (int k = 0; k < 3; ++k) text += fmt::format("1,{},9,{},0,{}000000000\n", k, k, begin + k);
    return folder.file(name, text).string();
  };
  const std::string tum =
      folder.file("one.tum", "10 0 0 0 0 0 0 1\n11 1 0 0 0 0 0 1\n12 2 0 0 0 0 0 1\n13 9 1 0 0 0 0 1\n").string();
  const std::string together = of_second("together.csv", 11);
  expect_failure(call({"error", together, tum}), 2,
                 "one.tum: sessions 0 and 1 are both under way at 12.000 s, and a trajectory does not say of which it is; a "
                 "table like poses.csv does");
  EXPECT_EQ(errors({"error", together, together})["ate"]["translation"]["count"], 6) << "by session and name";
  EXPECT_EQ(errors({"error", of_second("in_turn.csv", 12), tum})["ate"]["translation"]["count"], 5);
}

TEST_F(ErrorCommand, RefusesATrajectoryThatIsInTwoPlacesAtOnce) {
  const std::string one = folder.file("one.tum", "10.5 0 0 0 0 0 0 1\n11.5 1 0 0 0 0 0 1\n").string();
  const std::string two =
      folder.file("two.tum", "10.5 0 0 0 0 0 0 1\n11.5 1 0 0 0 0 0 1\n10.5 5 0 0 0 0 0 1\n11.5 6 0 0 0 0 0 1\n").string();
  for (const std::string& truth : {one, folder.file("t.csv", "pose,x,y,phi,stamp_ns\n0,0,0,0,10500000000\n").string()}) {
    expect_failure(call({"error", two, truth}), 2, "the trajectory of the map has two lines of 10.500 s; keep one or");
  }
  EXPECT_EQ(errors({"error", one, one})["ate"]["translation"]["count"], 2);
}

TEST_F(ErrorCommand, SaysWherePosesOfTheTruthAreOfAnotherSession) {
  const std::string second = folder.file("second.csv", "session,pose,x,y,phi\n1,4,0,0,0\n1,5,1,0,0\n").string();
  expect_failure(call({"error", second, truth}), 2,
                 "truth.g2o: names the poses of the map in session 0, and the map in others; a table whose column session says "
                 "of which session each pose is matches them");
}

TEST_F(ErrorCommand, SaysWhatMakesATruthOfAGraphWithoutValues) {
  expect_failure(call({"error", map, folder.file("log.g2o", kSmallLog).string()}), 3,
                 "the values of its poses; `mapjoin run TRUTH -o FOLDER` makes a map of it, which does");
}

TEST_F(ErrorCommand, SaysWhereTheAlignmentLeavesARotationFree) {
  const std::string line =
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\nVERTEX_SE3:QUAT 2 2 0 0 0 0 0 1\n";
  const std::string rolled =
      "VERTEX_SE3:QUAT 0 0 0 0 1 0 0 0\nVERTEX_SE3:QUAT 1 1 0 0 1 0 0 0\nVERTEX_SE3:QUAT 2 2 0 0 1 0 0 0\n";
  const auto with_feature = [](const std::string& poses, const std::string& y) {
    return "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n" + poses + "VERTEX_TRACKXYZ 9 1 " + y +
           " 0\nEDGE_SE3_TRACKXYZ 1 9 0 0 1 0 1 0 0 1 0 1\n";
  };
  const std::string plain = folder.file("plain.g2o", line).string();
  const std::string truth_of_plain = folder.file("rolled.g2o", rolled).string();
  const auto free = errors({"error", plain, truth_of_plain});
  EXPECT_EQ(free["ate"]["translation"]["count"], 3);
  EXPECT_EQ(free["ate"]["rotation"]["rms"], nullptr);
  EXPECT_THAT(call({"error", plain, truth_of_plain}).out, HasSubstr("rotations and features unknown: positions"));
  const std::string seen = folder.file("seen.g2o", with_feature(line, "3")).string();
  const std::string truth_of_seen = folder.file("seen_rolled.g2o", with_feature(rolled, "-3")).string();
  const auto known = errors({"error", seen, truth_of_seen});
  EXPECT_LT(known["ate"]["rotation"]["max"], 1e-7);
  EXPECT_LT(known["features"]["max"], 1e-9);
  EXPECT_THAT(call({"error", seen, truth_of_seen}).out, HasSubstr("3 of 3 poses, aligned as a whole, with features: rms"));
}

TEST_F(ErrorCommand, SpansStayWithinSessions) {
  const std::string two =
      folder.file("two.csv", "session,pose,x,y,phi\n0,1,0,0,0\n0,2,1,0,0\n1,1,9,9,0\n1,2,10,9,0\n").string();
  EXPECT_EQ(errors({"error", two, two, "--spans", "1,2"})["rpe"][0]["translation"]["count"], 2);
}

TEST_F(ErrorCommand, SpansCountThePosesOfTheMapAlsoWhereTheTruthHasFew) {
  const std::string run = "pose,x,y,phi\n0,0,0,0\n1,1.1,0,0\n2,2.2,0,0\n3,3.3,0,0\n4,4.4,0,0\n";
  const std::string few = "pose,x,y,phi\n0,0,0,0\n2,2,0,0\n4,4,0,0\n";
  const std::vector<std::string> words = {"error", folder.file("run.csv", run).string(), folder.file("few.csv", few).string()};
  std::vector<std::string> by_metres = words;
  by_metres.insert(by_metres.end(), {"--spans", "1.1,2.2", "--span-unit", "metres"});
  std::vector<std::string> by_steps = words;
  by_steps.insert(by_steps.end(), {"--spans", "1,2"});
  for (const auto& asked : {by_steps, by_metres}) {
    const auto rpe = errors(asked)["rpe"];
    EXPECT_EQ(rpe[0]["translation"]["count"], 0);
    EXPECT_EQ(rpe[1]["translation"]["count"], 2);
    EXPECT_NEAR(rpe[1]["translation"]["max"], 0.2, 1e-12);
  }
}

TEST_F(ErrorCommand, AFlatTrajectoryIsComparedInSpaceWithATruthThere) {
  const std::string flat = folder.file("flat.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
  const std::string high = folder.file("high.g2o",
                                       "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0.5 0 0 0 1\n"
                                       "VERTEX_SE3:QUAT 2 2 0 0 0 0 0 1\n");
  EXPECT_EQ(errors({"error", flat, high, "--align", "none"})["ate"]["translation"]["max"], 0.5);
}

TEST_F(ErrorCommand, RunPrintsTheSame) {
  const std::string log = kBundledLog;
  const std::string known = kBundledTruth;
  const std::string out = (folder.path() / "out.g2o").string();
  const auto of_run = errors({"run", log, "-o", out, "--truth", known});
  EXPECT_EQ(of_run["ate"], errors({"error", out, known})["ate"]);
  EXPECT_GT(of_run["ate"]["translation"]["rms"], 0.0);
}

}  // namespace
}  // namespace mapjoin::testing
