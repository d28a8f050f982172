// SPDX-License-Identifier: BSD-3-Clause
// The option --robust: what it leaves out, and what it says of that.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <tests/apps/command.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using Lines = std::vector<std::string>;

/// The bundled log with a wrong closure, and with an observation under the name of another feature.
class Robust : public ::testing::Test {
 protected:
  Robust() {
    std::string text = content_of(kBundledLog) + "EDGE_SE2 10 700 1 0 0 400 0 0 400 0 400\n";
    const std::string right = "EDGE_SE2_XY 399 1087 ";
    text.replace(text.find(right), right.size(), "EDGE_SE2_XY 399 1077 ");
    log = folder.file("log.g2o", text).string();
  }
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  std::string content(const std::string& name) const { return content_of(folder.path() / name); }
  Ended run_into(const std::string& name, const Lines& options = {}) const {
    Lines arguments = {"run", log, "--robust", "-o", path(name)};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Ended ended = call(arguments);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended;
  }
  static Lines lines_of(const std::string& text) {
    std::istringstream in(text);
    Lines lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }
  static void expect_refused(const Lines& arguments, const std::string& sentence) {
    const Ended ended = call(arguments);
    EXPECT_EQ(ended.exit_code, 2);
    EXPECT_THAT(ended.err, HasSubstr(sentence));
    EXPECT_EQ(ended.out, "");
  }

  TemporaryFolder folder;
  std::string log;
};

TEST_F(Robust, WritesALineForEachMeasurementThatWasLeftOut) {
  run_into("run");
  const Lines lines = lines_of(content("run/rejected.csv"));
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0], "kind,from,to,chi2,probability,why,from_session,to_session");
  for (const std::string& line : lines) EXPECT_EQ(std::ranges::count(line, ','), 7) << line;
  EXPECT_THAT(lines[1], AllOf(StartsWith("closure,10,700,"), EndsWith(",contradicted,0,0")));
  EXPECT_THAT(lines[2], AllOf(StartsWith("observation,399,1077,"), EndsWith(",contradicted,0,")));
}

TEST_F(Robust, WritesTheLogThatTheMapIsMadeOf) {
  run_into("run");
  const auto report = nlohmann::json::parse(content("run/report.json"));
  const auto again = report_of({"run", path("run/inliers.g2o")});
  EXPECT_NEAR(report["chi2"].get<double>(), again["chi2"].get<double>(), 1e-9 * report["chi2"].get<double>());
  EXPECT_EQ(report["dof"], again["dof"]);
  EXPECT_EQ(report["verdict"], "fits");
  EXPECT_EQ(again["verdict"], "fits");
  EXPECT_EQ(again["observations"], 2523);
  for (const std::string name : {"rejected.csv", "inliers.g2o"}) {
    EXPECT_THAT(report["files"].dump(), HasSubstr("/" + name + "\""));
  }
}

TEST_F(Robust, SaysHowManyOfHowManyWereLeftOut) {
  EXPECT_THAT(call({"run", log, "--robust"}).out,
              HasSubstr("\nrejected     1 of 1 closure, 1 of 2524 observations, with a confidence of 0.99\n"));
  EXPECT_THAT(call({"run", log}).out, Not(HasSubstr("rejected")));
  const auto robust = report_of({"run", log, "--robust", "--confidence", "0.9"})["robust"];
  EXPECT_EQ(robust["confidence"], 0.9);
  EXPECT_EQ(robust["rejected"], 2);
  EXPECT_EQ(robust["odometry"], 0);
  EXPECT_EQ(robust["closures"], 1);
  EXPECT_EQ(robust["observations"], 1);
  EXPECT_TRUE(report_of({"run", log})["robust"].is_null());
}

TEST_F(Robust, LeavesOutTheSameWhateverIsDoneWithTheLog) {
  EXPECT_EQ(report_of({"solve", log, "--robust"})["robust"]["rejected"], 2);
  EXPECT_THAT(call({"check", log}).out, HasSubstr("700"));
  const std::string few = (kBundledData / "cases/A_1900.g2o").string();
  EXPECT_THAT(call({"check", few, "--robust"}).out, HasSubstr("\nrejected     1 of 1 closure"));
  EXPECT_THAT(call({"compare", few, "--robust"}).out, HasSubstr("\nrejected     1 of 1 closure"));
  const auto compared = report_of({"compare", few, "--robust", "--poses-per-map", "5"});
  EXPECT_EQ(compared["robust"]["closures"], 1);
  EXPECT_EQ(compared["dof"], report_of({"solve", few, "--robust"})["dof"]);
}

TEST_F(Robust, IsAWarningOfACheckThatNamesWhatWasLeftOut) {
  const Ended ended = call({"check", log, "--robust"});
  EXPECT_EQ(ended.exit_code, 1) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("warning      left out by --robust, for they contradict the others: 2 measurements\n"));
  EXPECT_THAT(ended.out, HasSubstr("found        1 to look at\n"));
  const Ended first = call({"check", log, "--robust", "--most", "1", "--report", "-"});
  const auto finding = nlohmann::json::parse(first.out)["findings"][0];
  EXPECT_EQ(finding["check"], "rejected");
  EXPECT_EQ(finding["level"], "warning");
  EXPECT_EQ(finding["count"], 2);
  ASSERT_EQ(finding["where"].size(), 1U);
  EXPECT_THAT(finding["where"][0].get<std::string>(),
              AllOf(StartsWith("observation of feature 1077 from pose 399 (chi2 "), EndsWith(")")));
  const Ended nothing = call({"check", kBundledLog, "--robust"});
  EXPECT_EQ(nothing.exit_code, 0);
  EXPECT_THAT(nothing.out, HasSubstr("found        nothing to warn of\n"));
}

TEST_F(Robust, IsNamedInTheFolderOfAComparison) {
  const std::string few = (kBundledData / "cases/A_1900.g2o").string();
  const Lines words = {"compare", few, "--poses-per-map", "5", "-o", path("comparison")};
  ASSERT_EQ(call(words).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(path("comparison/rejected.csv")));
  Lines robust = words;
  robust.emplace_back("--robust");
  EXPECT_THAT(call(robust).out, HasSubstr("\nwritten      " + path("comparison/rejected.csv") + "\n"));
  ASSERT_EQ(call({"run", few, "--robust", "-o", path("run")}).exit_code, 0);
  EXPECT_EQ(content("comparison/rejected.csv"), content("run/rejected.csv"));
  EXPECT_THAT(content("comparison/compare.html"), HasSubstr("<dt>Rejected</dt><dd>1 of 1 closure"));
  EXPECT_THAT(call(words).err,
              HasSubstr(path("comparison/rejected.csv") + ": was there before, and this call did not write it"));
  robust.insert(robust.end(), {"--report", path("comparison/rejected.csv")});
  expect_refused(robust, "are one file");
}

TEST_F(Robust, GivesTheSameBytesForAnyNumberOfJobs) {
  run_into("one", {"--jobs", "1"});
  run_into("two", {"--jobs", "2"});
  for (const std::string name : {"rejected.csv", "inliers.g2o", "map.g2o", "map.svg"}) {
    EXPECT_EQ(content("one/" + name), content("two/" + name)) << name;
  }
}

TEST_F(Robust, TakesNoWordBesideAll) {
  expect_refused({"run", log, "--robust=some", "-o", path("run")}, "--robust is \"some\", but takes the word all, or none");
}

TEST_F(Robust, IsAskedForBeforeItsConfidence) {
  expect_refused({"run", log, "--confidence", "0.9"}, "--confidence is of --associate and --robust");
  expect_refused({"run", log, "--robust", "--confidence", "1"}, "the confidence must be between 0 and 1");
  expect_refused({"run", log, "--robust", "--confidence", "0"}, "the confidence must be between 0 and 1");
  expect_refused({"run", log, "--robust", "--confidence", "-1"}, "--confidence");
}

TEST_F(Robust, RefusesLocalMapsThatWereBuiltOfALog) {
  ASSERT_EQ(call({"build", log, "-o", path("log.maps"), "--quiet"}).exit_code, 0);
  expect_refused({"join", path("log.maps"), "--robust"}, "the local maps of a store are built already");
}

TEST_F(Robust, DrawsWhatWasLeftOutInThePicturesOfTheRun) {
  run_into("run");
  const std::string svg = content("run/map.svg");
  EXPECT_THAT(svg, HasSubstr(">rejected<"));
  ASSERT_EQ(call({"plot", path("run"), "-o", path("plot.svg"), "--quiet"}).exit_code, 0);
  EXPECT_EQ(content("plot.svg"), svg);
  ASSERT_EQ(call({"plot", path("run"), "-o", path("plot.html"), "--quiet"}).exit_code, 0);
  EXPECT_THAT(content("plot.html"), HasSubstr("\"rejected\""));
  folder.file("run/rejected.csv",
              "kind,from,to,chi2,probability,why,from_session,to_session\nclosure,10,7000,1,1,crowded,0,0\n");
  const Ended refused = call({"plot", path("run"), "-o", path("plot.svg")});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("rejected.csv: is not of the map beside it"));
}

}  // namespace
}  // namespace mapjoin::testing
