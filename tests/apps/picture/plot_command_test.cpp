// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <string_view>
#include <tests/apps/command.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Plot : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  /// The picture that `mapjoin plot` makes, as SVG.
  std::string picture(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "plot");
    arguments.insert(arguments.end(), {"-o", path("plot.svg"), "--quiet"});
    const Ended ended = call(arguments);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_EQ(ended.err, "");
    return content_of(path("plot.svg"));
  }
  void expect_refused(std::vector<std::string> arguments, int exit_code, const std::string& part) const {
    arguments.insert(arguments.begin(), "plot");
    const Ended ended = call(arguments);
    EXPECT_EQ(ended.exit_code, exit_code);
    EXPECT_THAT(ended.err, HasSubstr(part));
  }
  TemporaryFolder folder;
};

TEST_F(Plot, TheFolderOfARunShowsAllThatIsKnown) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("run"), "--covariances", "--poses-per-map", "50", "--quiet"}).exit_code, 0);
  const std::string svg = picture({path("run"), "--truth", kBundledTruth});
  for (const std::string name : {"local maps", "end poses", "features", "3σ of features", "3σ of poses", "odometry alone",
                                 "truth", "residual ≤ 2 × typical"}) {
    EXPECT_EQ(count_of(svg, ">" + name + "<"), 1U) << name;
  }
  EXPECT_EQ(count_of(svg, "<ellipse rx"), 143U + 20U);  // of 143 features, and of the ends of 20 maps
  EXPECT_EQ(picture({path("run/map.g2o"), "--truth", kBundledTruth}), svg);
  // The run's own picture is the same but for the truth.
  EXPECT_EQ(picture({path("run")}), content_of(path("run/map.svg")));
}

TEST_F(Plot, ALogWithoutValuesIsDrawnByItsOdometry) {
  const std::string svg = picture({kBundledLog});
  EXPECT_EQ(count_of(svg, ">odometry alone<"), 1U);
  EXPECT_EQ(count_of(svg, ">trajectory<"), 0U);
  EXPECT_EQ(count_of(svg, "<circle"), 143U + 1U);  // 143 features, and one in the legend
}

TEST_F(Plot, LocalMapsAreJoinedFirstAndTheirClosuresDrawn) {
  const std::string I = " 100 0 0 100 0 100\n";
  const std::string log = "EDGE_SE2 0 1 2 0 0" + I + "EDGE_SE2 1 2 2 0 1.6" + I + "EDGE_SE2 2 3 2 0 1.6" + I +
                          "EDGE_SE2 3 4 2 0 1.5" + I + "EDGE_SE2 4 0 2 -2 1.6" + I +
                          "EDGE_SE2_XY 0 7 1 1 100 0 100\nEDGE_SE2_XY 3 7 3 1 100 0 100\n";
  ASSERT_EQ(call({"build", folder.file("log.g2o", log).string(), "-o", path("maps"), "--poses-per-map", "2"}).exit_code, 0);
  const std::string svg = picture({path("maps"), "--covariances"});
  EXPECT_EQ(count_of(svg, ">local maps<"), 1U);
  EXPECT_EQ(count_of(svg, ">residual ≤ 2 × typical<"), 1U);
  EXPECT_EQ(count_of(svg, "<ellipse rx"), 1U + 2U);
  EXPECT_EQ(count_of(picture({path("maps")}), "<ellipse"), 0U);
  EXPECT_EQ(picture({path("maps"), "--jobs", "1"}), picture({path("maps"), "--jobs", "2"}));
}

TEST_F(Plot, ShowsWhereAMapIsBentByAWrongObservation) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("run"), "--quiet"}).exit_code, 0);
  EXPECT_EQ(count_of(picture({path("run")}), "residual &gt; 8 × typical"), 0U);
  std::string log = content_of(kBundledLog);
  const std::string right = "EDGE_SE2_XY 399 1087 ";
  log.replace(log.find(right), right.size(), "EDGE_SE2_XY 399 1077 ");
  ASSERT_EQ(call({"run", folder.file("wrong.g2o", log).string(), "-o", path("bent"), "--quiet"}).exit_code, 0);
  EXPECT_EQ(count_of(picture({path("bent")}), "residual &gt; 8 × typical"), 1U);
}

TEST_F(Plot, KnowsAPageByItsExtensionInAnyCase) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("run"), "--no-verdict", "--quiet"}).exit_code, 0);
  ASSERT_EQ(call({"plot", path("run"), "-o", path("MAP.HTML"), "--quiet"}).exit_code, 0);
  EXPECT_EQ(count_of(content_of(path("MAP.HTML")), "<!DOCTYPE html>"), 1U);
}

TEST_F(Plot, SaysThatEllipsesAreLargerThanTheMap) {
  const std::string log =
      "EDGE_SE2 0 1 1 0 0 400 0 0 400 0 400\nEDGE_SE2 1 2 1 0 0 0.01 0 0 0.01 0 0.01\nEDGE_SE2_XY 0 7 1 1 400 0 400\n";
  const std::string words = "the 3σ ellipses of 1 pose and 0 features are larger than the map, and are capped at its size\n";
  const Ended run = call({"run", folder.file("log.g2o", log).string(), "-o", path("run"), "--covariances", "--quiet"});
  EXPECT_EQ(run.err, "mapjoin: map.svg: " + words);
  EXPECT_EQ(count_of(content_of(path("run/map.svg")), "3σ of poses (capped at the map's size)"), 1U);
  for (const std::string name : {"map.svg", "map.html"}) {
    const Ended plotted = call({"plot", path("run"), "-o", path(name), "--quiet"});
    EXPECT_EQ(plotted.err, "mapjoin: " + path("run") + ": " + words);
    EXPECT_EQ(count_of(content_of(path(name)), "3σ of poses (capped at the map's size)"), 1U);
  }
}

TEST_F(Plot, APageIsTheSameForAnyNumberOfThreads) {
  ASSERT_EQ(call({"build", kBundledLog, "-o", path("maps"), "--quiet"}).exit_code, 0);
  for (const std::string jobs : {"1", "2"}) {
    const Ended ended = call({"plot", path("maps"), "--covariances", "-o", path(jobs + ".html"), "--jobs", jobs});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
  }
  EXPECT_EQ(content_of(path("1.html")), content_of(path("2.html")));
}

TEST_F(Plot, EndsWhenItIsInterrupted) {
  ASSERT_EQ(call({"simulate", "--poses", "8000", "-o", path("log.g2o"), "--quiet"}).exit_code, 0);
  ASSERT_EQ(call({"build", path("log.g2o"), "-o", path("maps"), "--quiet"}).exit_code, 0);
  Process process(command_line({"plot", path("maps"), "-o", path("page.html")}), {});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 130);
  EXPECT_EQ(process.standard_error(), "mapjoin: interrupted\n");
  EXPECT_FALSE(std::filesystem::exists(path("page.html")));
}

TEST_F(Plot, SeveralMapsAreLaidOnTheFirstOne) {
  const std::string map = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 10 0 0\nVERTEX_SE2 2 10 5 0\n";
  const std::string turned = "VERTEX_SE2 0 100 7 1.5707963267948966\nVERTEX_SE2 1 100 17 0\nVERTEX_SE2 2 95 17 0\n";
  const std::vector<std::string> both = {folder.file("a.g2o", map).string(), folder.file("b.g2o", turned).string()};
  const std::string aligned = picture(both);
  EXPECT_EQ(count_of(aligned, "M40.0,500.0 960.0,500.0 960.0,40.0"), 2U) << aligned;
  EXPECT_EQ(count_of(aligned, ">a.g2o<") + count_of(aligned, ">b.g2o<"), 2U);
  EXPECT_EQ(count_of(picture({both[0], both[1], "--no-align"}), "M40.0,500.0 960.0,500.0 960.0,40.0"), 0U);
}

TEST_F(Plot, MapsOfOneNameAreToldApartByTheirFolders) {
  const std::string map = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 10 0 0\nVERTEX_SE2 2 10 5 0\n";
  for (const std::string name : {"one", "two"}) std::filesystem::create_directory(path(name));
  const std::vector<std::string> both = {folder.file("one/map.g2o", map).string(), folder.file("two/map.g2o", map).string()};
  const std::string svg = picture(both);
  for (const std::string& name : both) EXPECT_EQ(count_of(svg, ">" + name + "<"), 1U);
}

TEST_F(Plot, MapsThatShareNothingAreDrawnAsTheyStand) {
  const std::string a = folder.file("a.g2o", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 10 0 0\n").string();
  const std::string b = folder.file("b.g2o", "VERTEX_SE2 5 0 0 0\nVERTEX_SE2 6 10 0 0\n").string();
  const Ended ended = call({"plot", a, b, "-o", path("plot.svg")});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("b.g2o: shares too little with the first map"), Not(HasSubstr("a.g2o: shares"))));
}

TEST_F(Plot, SaysOfHowManyPosesTheTruthIs) {
  const std::string map =
      folder.file("map.tum", "9.5 0 0 0 0 0 0 1\n10.5 1 0 0 0 0 0 1\n11.5 1 1 0 0 0 0 1\n12.5 1 2 0 0 0 0 1\n").string();
  const std::string truth =
      folder.file("truth.tum", "9.502 0 0 0 0 0 0 1\n10.495 1 0 0 0 0 0 1\n11.501 1 1 0 0 0 0 1\n12 1 2 0 0 0 0 1\n").string();
  const Ended ended = call({"plot", map, "--truth", truth, "-o", path("plot.svg")});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_EQ(ended.err, "mapjoin: " + truth + ": has 3 of the 4 poses of the first map, and is drawn at no others\n");
}

TEST_F(Plot, LeavesOutOfMapAndTruthWhatItIsTold) {
  const std::string map = folder.file("map.g2o", "VERTEX_SE2 0 0 0 0\nSCAN 1\nVERTEX_SE2 1 1 0 0\n").string();
  const std::string truth = folder.file("truth.g2o", "VERTEX_SE2 0 0 0 0\nIMAGE 1\nVERTEX_SE2 1 1 0 0\n").string();
  const std::vector<std::string> words = {"plot", map, "--truth", truth, "-o", path("plot.svg"), "--skip-unknown"};
  const Ended ended = call(words);
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_EQ(ended.err, "mapjoin: " + map + ": left out: SCAN lines (1)\n");
  const std::string sound = folder.file("sound.g2o", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n").string();
  EXPECT_EQ(call({"plot", sound, "--truth", truth, "-o", path("plot.svg")}).err,
            "mapjoin: " + truth + ":2:1: unknown tag 'IMAGE'; --skip-unknown leaves such lines out\n");
}

TEST_F(Plot, RefusesATruthOfNothingInTheMap) {
  const std::string map = folder.file("map.csv", "pose,x,y,phi\n1,0,0,0\n2,1,0,0\n").string();
  const std::string truth = folder.file("truth.csv", "pose,x,y,phi\n7,0,0,0\n8,1,0,0\n").string();
  const Ended ended = call({"plot", map, "--truth", truth, "-o", path("plot.svg")});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_EQ(ended.err,
            "mapjoin: " + truth + ": has no pose or feature of " + map + ", by name, time or count; leave --truth out\n");
  EXPECT_FALSE(std::filesystem::exists(path("plot.svg")));
}

TEST_F(Plot, TheTruthOfATrajectoryMayHaveNames) {
  const std::string map = folder.file("map.kitti", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n").string();
  const std::string truth = folder.file("truth.csv", "pose,x,y,phi\n7,0,0,0\n8,1,0,0\n").string();
  EXPECT_EQ(call({"plot", map, "--truth", truth, "-o", path("plot.svg")}).err, "");
}

TEST_F(Plot, RefusesWhatDoesNotGoTogether) {
  const std::string other = (kBundledData / "manhattan3d.g2o").string();
  expect_refused({kBundledLog, other, "-o", path("plot.svg")}, 2, "is not of the same dimension as");
  expect_refused({kBundledLog, path("nowhere"), "-o", path("plot.svg")}, 3, "nowhere");
  expect_refused({kBundledLog, "-o", path("no/such/folder.svg")}, 5, "no/such");
  const std::string map = folder.file("a.g2o", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 10 0 0\n").string();
  expect_refused({map, "-o", map}, 2, "MAP and --output are one file");
  EXPECT_FALSE(std::filesystem::exists(path("plot.svg")));
}

TEST_F(Plot, TheFolderOfARunOfSeveralSessionsIsReadByTheNamesOfTheirLogs) {
  const auto log_from = [&](const std::string& name, int first) {
    std::string text;
    for (int k = 0; k < 20; ++k) {
      text += fmt::format("EDGE_SE2 {} {} 1 0 0.1 100 0 0 100 0 400\n", first + k, first + k + 1);
      for (const int f : {0, 1}) text += fmt::format("EDGE_SE2_XY {} {} 1 {} 25 0 25\n", first + k, 5000 + (k + f) / 2, f + 1);
    }
    return folder.file(name, text).string();
  };
  // The ids of the second session are lower than those of the first, then the same: in a g2o file they are others.
  const std::string low = log_from("low.g2o", 0);
  for (const auto& [a, b] : {std::pair(log_from("high.g2o", 1000), low), {low, log_from("same.g2o", 0)}}) {
    ASSERT_EQ(call({"run", a, b, "--features", "shared", "--keep-copies", "-o", path("run"), "--covariances", "--robust",
                    "--poses-per-map", "5"})
                  .exit_code,
              0);
    const Ended ended = call({"plot", path("run"), "-o", path("plot.svg")});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("42 poses, 11 features, 8 local maps"));
    const std::string svg = content_of(path("plot.svg"));
    EXPECT_EQ(count_of(svg, "<ellipse rx"), 8U + 11U);
    EXPECT_EQ(count_of(svg, ">rejected<"), 1U);
  }
}

TEST_F(Plot, TheCovariancesOfATableOfPosesAreDrawnAndOfATrajectoryNot) {
  for (const std::string name : {"map.csv", "map.tum"}) {
    ASSERT_EQ(call({"solve", kBundledLog, "-o", path(name), "--covariances", "--quiet"}).exit_code, 0);
    EXPECT_EQ(count_of(picture({path(name)}), ">3σ of poses<"), name == "map.csv" ? 1U : 0U);
  }
}

TEST_F(Plot, AFolderThatLostItsNamesIsDrawnWithoutLocalMapsAndSaysSo) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("run"), "--quiet"}).exit_code, 0);
  std::filesystem::remove(path("run/poses.csv"));
  std::filesystem::remove(path("run/features.csv"));
  const Ended ended = call({"plot", path("run"), "-o", path("plot.svg")});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.out, HasSubstr("0 local maps"));
  EXPECT_THAT(ended.err, HasSubstr("run: without its poses.csv neither local maps nor what was rejected are drawn"));
}

TEST_F(Plot, WhatLiesBesideAMapMustBeOfIt) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("run"), "--covariances", "--quiet"}).exit_code, 0);
  const std::string certain = content_of(path("run/covariances.json"));
  folder.file("run/covariances.json", certain.substr(0, certain.size() / 2));
  expect_refused({path("run"), "-o", path("plot.svg")}, 3, "covariances.json: is not as this mapjoin writes it; remove it");
  folder.file("run/covariances.json", R"({"dimension": 2, "poses": [], "features": []})");
  expect_refused({path("run"), "-o", path("plot.svg")}, 3, "covariances.json: is not of the map beside it");
  std::filesystem::remove(path("run/covariances.json"));
  folder.file("run/report.json", R"({"join": {"maps": [{"session": 0, "pose": 5, "end": 777777, "chi2": 1, "rows": 2}]}})");
  expect_refused({path("run"), "-o", path("plot.svg")}, 3, "report.json: is not of the map beside it");
  ASSERT_EQ(call({"solve", kBundledLog, "--max-iterations", "1", "-o", path("run/map.g2o"), "--quiet"}).exit_code, 4);
  expect_refused({path("run"), "-o", path("plot.svg")}, 3, "poses.csv: is not of the map beside it");
}

}  // namespace
}  // namespace mapjoin::testing
