// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tests/apps/follow_fixture.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST_F(Follow, ALogThatGrowsEndsAsTheRunOfTheWhole) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("whole")}).exit_code, 0);
  std::ofstream growing(path("log.g2o"));
  const std::size_t slices = 20;
  Process process(
      command_line({"run", path("log.g2o"), "--follow", "--idle", "2", "--steps", path("steps"), "-o", path("map")}));
  for (std::size_t k = 0; k < slices; ++k) {
    for (std::size_t l = k * log.size() / slices; l < (k + 1) * log.size() / slices; ++l) growing << log[l];
    growing.flush();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(process.wait(), 0) << process.standard_error();
  for (const std::string name : {"map.g2o", "poses.csv", "features.csv"}) {
    EXPECT_EQ(content_of(path("map/" + name)), content_of(path("whole/" + name))) << name;
  }
  EXPECT_THAT(process.standard_output(), HasSubstr("polished     converged"));
  std::size_t maps = 0;
  for (const auto& step : steps()) {
    EXPECT_TRUE(step.at("joined"));
    EXPECT_EQ(step.at("map"), maps + 1);
    maps += step.at("maps").get<std::size_t>();
  }
  EXPECT_EQ(maps, 100u);  // each of 10 poses
  EXPECT_GT(steps().size(), 10u);
  EXPECT_EQ(steps().back().at("last_pose"), 999);
}

TEST_F(Follow, WrongClosuresAreLeftOutAsTheLogGrows) {
  const std::string wrong = "EDGE_SE2 10 700 1 0 0 400 0 0 400 0 400\n";
  log.push_back(wrong);
  log = as_driven(log);
  std::ofstream(path("whole.g2o")) << [&] {
    std::string all;
    for (const auto& line : log) all += line;
    return all;
  }();
  ASSERT_EQ(call({"run", path("whole.g2o"), "--robust", "-o", path("whole")}).exit_code, 0);
  std::ofstream growing(path("log.g2o"));
  Process process(command_line(
      {"run", path("log.g2o"), "--follow", "--robust", "--idle", "600", "--steps", path("steps"), "-o", path("map")}));
  const std::size_t slices = 5;
  for (std::size_t k = 0; k < slices; ++k) {
    for (std::size_t l = k * log.size() / slices; l < (k + 1) * log.size() / slices; ++l) growing << log[l];
    growing.flush();
    await_steps(k == 0 ? 1 : 20 * k);  // the maps of later slices then come one by one
  }
  await_steps(80);
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 0) << process.standard_error();
  for (const std::string name : {"map.g2o", "poses.csv", "rejected.csv", "inliers.g2o"}) {
    EXPECT_EQ(content_of(path("map/" + name)), content_of(path("whole/" + name))) << name;
  }
  EXPECT_THAT(content_of(path("map/rejected.csv")), HasSubstr("closure,10,700,"));
  const auto closures = nlohmann::json::array({nlohmann::json::array({10, 700})});
  for (const auto& step : steps()) {
    EXPECT_EQ(step.at("rejected"), step.at("last_pose") == 700 ? closures : nlohmann::json::array()) << step;
    EXPECT_EQ(step.at("readmitted"), nlohmann::json::array());
    EXPECT_EQ(step.at("left_out"), step.at("last_pose") < 700 ? 0 : 1);
  }
}

TEST_F(Follow, OfALogThatIsThereWrongClosuresAreLeftOutAtOnce) {
  std::ofstream(path("log.g2o")) << content_of(kBundledLog) + "EDGE_SE2 10 700 1 0 0 400 0 0 400 0 400\n";
  const Ended ended = call({"run", path("log.g2o"), "--follow", "--robust", "--idle", "0", "--steps", path("steps")});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_TRUE(steps().front().at("judged"));
  EXPECT_EQ(steps().front().at("left_out"), 1);
  EXPECT_EQ(steps().front().at("rejected"), nlohmann::json::array({nlohmann::json::array({10, 700})}));
  EXPECT_THAT(ended.out, HasSubstr("rejected"));
}

TEST_F(Follow, AClosureOfWhatCannotBeDeterminedIsNotJudged) {
  std::ofstream(path("log.g2o")) << "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 1 9 0.8 1 0 0 0\n"
                                    "EDGE_SE2 1 0 -5 3 1 4 0 0 4 0 4\n";
  const Ended ended = call({"run", path("log.g2o"), "--follow", "--robust", "--idle", "0"});
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.err, HasSubstr("feature 9 cannot be determined"));
}

TEST_F(Follow, AFileThatIsCompleteIsJoinedAtOnce) {
  fs::copy_file(kBundledData / "manhattan3d.g2o", path("log.g2o"));
  const Ended ended = call({"run", path("log.g2o"), "--follow", "--idle", "0", "--steps", "-"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  std::istringstream lines(ended.out);
  double chi2 = 0.0;
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count) chi2 = nlohmann::json::parse(line).at("chi2");
  EXPECT_EQ(count, 2u);            // one step for all that was complete, one for the last map
  EXPECT_NEAR(chi2, 884.68, 9.0);  // chi2 of a join of its maps of 10 poses (IncrementalData compares every step)
}

TEST_F(Follow, IdsMayBeTimes) {
  fs::copy_file(kBundledData / "manhattan3d.g2o", path("log.g2o"));
  const std::string map = path("map.tum");
  const Ended ended = call({"run", path("log.g2o"), "--follow", "--idle", "0", "--ids-are-nanoseconds", "--quiet", "-o", map});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(content_of(map), HasSubstr("\n0.000000007 "));
  EXPECT_THAT(ended.err, HasSubstr("log.g2o: with --ids-are-nanoseconds all of it takes less than a millisecond"));
}

TEST_F(Follow, IdsMayBeInNoOrderAtAll) {
  // Ids are a permutation of the poses: only the edges tell how they were driven.
  std::ofstream shuffled(path("log.g2o"));
  for (const std::string& line : log) {
    std::istringstream words(line);
    std::string tag, rest;
    int base = 0;
    int target = 0;
    words >> tag >> base >> target;
    std::getline(words, rest);
    const auto name = [](int pose) { return pose * 377 % 1000; };
    if (tag == "EDGE_SE2") shuffled << tag << ' ' << name(base) << ' ' << name(target) << rest << '\n';
    if (tag == "EDGE_SE2_XY") shuffled << tag << ' ' << name(base) << ' ' << target << rest << '\n';
  }
  shuffled.close();
  const Ended ended = call({"run", path("log.g2o"), "--follow", "--idle", "0", "-o", path("map")});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  ASSERT_EQ(call({"run", path("log.g2o"), "-o", path("whole")}).exit_code, 0);
  EXPECT_TRUE(content_of(path("map/poses.csv")) == content_of(path("whole/poses.csv")));
}

TEST_F(Follow, AtCtrlCWhatIsThereIsWritten) {
  std::ofstream(path("log.g2o")) << [&] {
    std::string half;
    for (std::size_t l = 0; l < log.size() / 2; ++l) half += log[l];
    return half + "EDGE_SE2 half a li";
  }();
  Process process(
      command_line({"run", path("log.g2o"), "--follow", "--idle", "600", "--steps", path("steps"), "-o", path("map")}));
  await_steps(1);
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 0) << process.standard_error();
  EXPECT_TRUE(fs::exists(path("map/map.g2o")));
  EXPECT_EQ(steps().size(), 2u);  // the last, incomplete map is closed
}

TEST_F(Follow, WhatIsWrongWithTheLogIsSaidAfterCtrlC) {
  std::ofstream(path("log.g2o")) << [&] {
    std::string parts = "EDGE_SE2 5000 5001 1 0 0 1 0 0 1 0 1\n";  // tied to nothing
    for (std::size_t l = 0; l < log.size() / 2; ++l) parts += log[l];
    return parts;
  }();
  Process process(command_line({"run", path("log.g2o"), "--follow", "--idle", "600", "--steps", path("steps")}));
  await_steps(1);
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 3);
  EXPECT_THAT(process.standard_error(), ::testing::HasSubstr("nothing ties its 2 parts together"));
}

TEST_F(Follow, ALineThatIsWrongEndsItAndWhatIsThereIsKept) {
  std::ofstream growing(path("log.g2o"));
  for (std::size_t l = 0; l < 2000; ++l) growing << log[l];
  growing.flush();
  Process process(
      command_line({"run", path("log.g2o"), "--follow", "--idle", "600", "--steps", path("steps"), "-o", path("map")}));
  await_steps(1);
  growing << "EDGE_SE2 1 2 here\n" << log[2000];
  growing.flush();
  EXPECT_EQ(process.wait(), 3);
  EXPECT_THAT(process.standard_error(), HasSubstr("log.g2o:2001:14: "));
  EXPECT_THAT(process.standard_error(), HasSubstr("; the map of what stands before it is written"));
  EXPECT_TRUE(fs::exists(path("map/map.g2o")));
  const Ended again =
      call({"run", path("log.g2o"), "--follow", "--idle", "600", "--steps", path("again"), "-o", path("map.tum")});
  EXPECT_EQ(again.exit_code, 3);
  EXPECT_THAT(again.err, HasSubstr("; the map of what stands before it is written"));
  EXPECT_TRUE(fs::is_regular_file(path("map.tum")));
}

TEST_F(Follow, ALogThatIsReplacedEndsItAndWhatWasThereIsKept) {
  std::ofstream(path("log.g2o")) << [&] {
    std::string begin;
    for (std::size_t l = 0; l < 2000; ++l) begin += log[l];
    return begin;
  }();
  Process process(
      command_line({"run", path("log.g2o"), "--follow", "--idle", "600", "--steps", path("steps"), "-o", path("map")}));
  await_steps(1);
  std::ofstream(path("new.g2o")) << log[0] << log[1];
  fs::rename(path("new.g2o"), path("log.g2o"));
  EXPECT_EQ(process.wait(), 3);
  EXPECT_THAT(process.standard_error(), HasSubstr("log.g2o: the file was replaced, renamed or removed while it was followed"));
  EXPECT_THAT(process.standard_error(), HasSubstr("; the map of what stands before it is written"));
  EXPECT_TRUE(fs::exists(path("map/map.g2o")));
}

/// Vertices and edges wait for each other, as they may where the log is cut.
TEST_F(Follow, AClosureToAnEliminatedPoseJoinsTheOthersWithTheNextMap) {
  std::ofstream growing(path("log.g2o"));
  growing << "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 777 0 0 0\n";
  for (std::size_t l = 0; l < 2000; ++l) growing << log[l];
  growing.flush();
  Process process(command_line({"run", path("log.g2o"), "--follow", "--idle", "600", "--steps", path("steps")}));
  await_steps(1);
  growing << "EDGE_SE2 5 15 0 0 0 1e-6 0 0 1e-6 0 1e-6\n";
  for (std::size_t l = 2000; l < 2200; ++l) growing << log[l];
  growing.flush();
  await_steps(2);
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 0) << process.standard_error();
  const auto all = steps();
  std::size_t maps = 0;
  for (const auto& step : all) {
    EXPECT_EQ(step.at("map"), maps + 1) << "the maps before stay";
    maps += step.at("maps").get<std::size_t>();
  }
  EXPECT_GT(all.back().at("dof"), all.front().at("dof"));
}

/// A pose that is measured only from the World is in no map.
TEST_F(Follow, AStepWithoutAMapIsOfNoPoses) {
  folder.file("log.g2o", "EDGE_PRIOR_SE2 7 1 2 0 1 0 0 1 0 1\n");
  call({"run", path("log.g2o"), "--follow", "--idle", "0", "--steps", path("steps")});
  ASSERT_EQ(steps().size(), 1u);
  EXPECT_EQ(steps()[0].at("maps"), 0);
  EXPECT_TRUE(steps()[0].at("first_pose").is_null());
  EXPECT_TRUE(steps()[0].at("last_pose").is_null());
}

TEST_F(Follow, WhatCannotBeFollowedIsSaid) {
  EXPECT_EQ(call({"run", path("none.g2o"), "--follow"}).exit_code, 3);
  const Ended zipped = call({"run", kCommand, "--follow", "--idle", "0"});
  EXPECT_EQ(zipped.exit_code, 3);
  EXPECT_NE(zipped.err, "");
  const std::string isam = path("log.isam");
  ASSERT_EQ(call({"convert", kBundledLog, isam, "--quiet"}).exit_code, 0);
  expect_failure(call({"run", isam, "--follow", "--idle", "0"}), 3,
                 isam + ": only g2o can be followed, and this is another format; `mapjoin convert " + isam + " LOG.g2o`");
  folder.file("steps", "of an earlier call\n");
  EXPECT_EQ(call({"run", isam, "--follow", "--idle", "0", "--steps", path("steps")}).exit_code, 3);
  EXPECT_EQ(content_of(path("steps")), "of an earlier call\n");
  EXPECT_EQ(call({"run", kBundledLog, "--follow", "--idle", "0", "--steps", path("steps"), "--quiet"}).exit_code, 0);
  EXPECT_EQ(content_of(path("steps")).front(), '{') << "emptied at the first step";
  const Ended unfollowed = call({"run", path("none.g2o"), "--idle", "3"});
  EXPECT_EQ(unfollowed.exit_code, 2);
  EXPECT_THAT(unfollowed.err, HasSubstr("--idle is for --follow"));
  EXPECT_EQ(call({"run", path("none.g2o"), "--follow", "--steps", "-", "--report", "-"}).exit_code, 2);
  const Ended other = call({"run", path("none.g2o"), "--follow", "--from", "toro"});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("--follow is for one log in g2o, without --stamps, --gps and --parts"));
}

}  // namespace
}  // namespace mapjoin::testing
