// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/store.hpp>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// One sentence on standard error, after the command's name, and nothing on standard output.
void expect_failure(const Ended& ended, int exit_code, const std::string& part) {
  EXPECT_EQ(ended.exit_code, exit_code);
  EXPECT_EQ(ended.out, "");
  EXPECT_THAT(ended.err, AllOf(StartsWith("mapjoin: "), HasSubstr(part)));
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
}

class BadInput : public ::testing::Test {
 protected:
  /// A log with this content is refused, with a message that has its name followed by `place` and `part`.
  void expect_refused(const std::string& content, const std::string& place, const std::string& part) const {
    const auto log = folder.file("log.g2o", content);
    for (const std::string command : {"run", "info"}) {
      const Ended ended = call({command, log.string()});
      if (command == "info" && ended.exit_code == 0) continue;  // What only a solve finds out.
      expect_failure(ended, 3, part);
      EXPECT_THAT(ended.err, HasSubstr(log.string() + place)) << command;
    }
    expect_failure(call({"solve", log.string(), "-o", (folder.path() / "map.g2o").string()}), 3, part);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "map.g2o"));
  }
  TemporaryFolder folder;
};

TEST_F(BadInput, AMissingFileIsNamed) {
  expect_failure(call({"run", (folder.path() / "nowhere.g2o").string()}), 3, "nowhere.g2o: No such file or directory");
  expect_failure(call({"info", (folder.path() / "nowhere.g2o").string()}), 3, "nowhere.g2o");
  expect_failure(call({"join", (folder.path() / "nowhere").string(), "-o", (folder.path() / "map.g2o").string()}), 3,
                 "nowhere");
}

TEST_F(BadInput, AMalformedNumberIsNamedWithItsPlace) {
  expect_refused(kSmallLog + "EDGE_SE2 2 3 1 O 0 1 0 0 1 0 1\n", ":5:16: ", "O");
}

TEST_F(BadInput, ATruncatedLineIsNamedWithItsPlace) {
  expect_refused(kSmallLog + "EDGE_SE2 2 3 1 0\n", ":5:", "");
}

TEST_F(BadInput, NotANumberIsRefused) {
  expect_refused(kSmallLog + "EDGE_SE2 2 3 nan 0 0 1 0 0 1 0 1\n", ":5:14: ", "nan");
}

TEST_F(BadInput, AnIndefiniteInformationMatrixIsNamedByItsEdge) {
  expect_refused(kSmallLog + "EDGE_SE2 2 3 1 0 0 1 0 0 -1 0 1\n", ":5:", "2-3");
}

TEST_F(BadInput, AnUnknownIdIsNamed) {
  expect_refused("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 5 1 0 0 1 0 0 1 0 1\n",
                 ":4:", "5");
}

TEST_F(BadInput, ALogThatFallsApartIsNamedByItsParts) {
  expect_refused(kSmallLog + "EDGE_SE2 10 11 1 0 0 1 0 0 1 0 1\n", "", "10");
}

TEST_F(BadInput, NumbersTooLargeForAMapAreRefused) {
  const auto log = folder.file("log.g2o", "EDGE_SE2 0 1 1e308 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1e308 0 0 1 0 0 1 0 1\n");
  const auto out = folder.path() / "out";
  for (const std::string command : {"run", "solve"}) {
    expect_failure(call({command, log.string(), "-o", out.string()}), 3, "the map is not finite");
    EXPECT_FALSE(std::filesystem::exists(out)) << command;
  }
}

TEST_F(BadInput, ATruncatedMatFileIsRefused) {
  const auto log = folder.file("log.mat", "MATLAB 5.0 MAT-file, but no more");
  expect_failure(call({"run", log.string()}), 3, "log.mat");
}

TEST_F(BadInput, LocalMapsInThePlaceOfALogAreToldApart) {
  const auto log = folder.file("log.g2o", kSmallLog);
  const std::string store = (folder.path() / "maps").string();
  ASSERT_EQ(call({"build", log.string(), "-o", store}).exit_code, 0);
  expect_failure(call({"run", store}), 3, "`mapjoin join` takes");
  expect_failure(call({"run", folder.path().string()}), 3, "`mapjoin join` takes");
  expect_failure(call({"join", log.string(), "-o", (folder.path() / "map.g2o").string()}), 3, "neither");
}

TEST_F(BadInput, AStoreThatIsCutShortIsRefused) {
  const auto log = folder.file("log.g2o", kSmallLog);
  const auto store = folder.path() / "maps";
  ASSERT_EQ(call({"build", log.string(), "-o", store.string()}).exit_code, 0);
  std::filesystem::resize_file(store, std::filesystem::file_size(store) / 2);
  expect_failure(call({"join", store.string(), "-o", (folder.path() / "map.g2o").string()}), 3, "maps");
}

TEST_F(BadInput, WhatIsWrongInAStoreIsSaidOfTheStore) {
  Log<2> log = std::get<Log<2>>(*open_log(folder.file("log.g2o", kSmallLog)));
  log.graph.feature_factors.clear();
  const auto store = folder.path() / "maps";
  auto writer = StoreWriter<2>::open(store, log, {{0, 2, false}}, "");
  ASSERT_TRUE(writer && writer->finish());
  const Ended ended = call({"join", store.string(), "-o", (folder.path() / "map.g2o").string()});
  expect_failure(ended, 3, "feature 7 is never observed");
  EXPECT_THAT(ended.err, StartsWith("mapjoin: " + store.string() + ": "));
}

TEST(Repair, TakesTheNearestSemidefiniteMatrixAndCountsIt) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog + "EDGE_SE2 1 2 1 0 0 2 0 0 2 0 -1\n");
  ASSERT_EQ(call({"run", log.string()}).exit_code, 3);
  EXPECT_EQ(report_of({"run", log.string(), "--repair-information"}).at("repaired_informations"), 1);
}

TEST(Repair, SaysHowAsymmetricWhatItTookWas) {
  const TemporaryFolder folder;
  const auto map = [&](const std::string& above) {
    folder.file("localmap_1.txt", "0\n3\n-1 1\n-1 0.5\n-1 0.1\n4 " + above + " 0\n1 3 0\n0 0 2\n");
  };
  map("1.0000004");
  const Ended taken = call({"join", folder.path().string()});
  EXPECT_EQ(taken.exit_code, 0) << taken.err;
  EXPECT_THAT(taken.out, HasSubstr("1 information matrix or covariance was replaced by the symmetric part: entries across the "
                                   "diagonal differ by up to 1e-07 of the largest"));
  map("1.1");
  const Ended refused = call({"join", folder.path().string()});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("the information matrix of map 1 is not symmetric"));
  EXPECT_THAT(refused.err, HasSubstr("--repair-information takes its symmetric part"));
  EXPECT_EQ(report_of({"join", folder.path().string(), "--repair-information"}).at("symmetrised_matrices"), 1);
}

TEST_F(BadInput, ASecondFixedPoseNeedsAValue) {
  const auto log = folder.file("log.g2o", "FIX 0\nFIX 2\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  expect_failure(call({"run", log.string()}), 3, "pose 2 is fixed beside pose 0, but nothing says where");
}

TEST(Usage, EveryViolationIsNamed) {
  const Ended ended =
      call({"run", "log", "--jobs", "none", "--schedule", "forest", "--poses-per-map", "0", "--metres-per-map", "x"});
  expect_failure(ended, 2, "--jobs is \"none\"");
  EXPECT_THAT(ended.err, AllOf(HasSubstr("--schedule is \"forest\""), HasSubstr("--poses-per-map is \"0\""),
                               HasSubstr("--metres-per-map is \"x\""), HasSubstr("only one of")));
}

TEST(Usage, WhatIsMissingOrUnknownIsNamed) {
  expect_failure(call({}), 2, "command");
  expect_failure(call({"run"}), 2, "LOG");
  expect_failure(call({"build", "log"}), 2, "--output");
  expect_failure(call({"fly", "log"}), 2, "fly");
  expect_failure(call({"run", "log", "--faster"}), 2, "--faster");
  expect_failure(call({"simulate", "-o", "log", "--chance", "2", "--block", "1.5"}), 2, "chance");
}

TEST(Usage, ThreadsHaveALimit) {
  expect_failure(call({"run", "log", "--jobs", "1025"}), 2, "not a whole number from 1 to 1024");
}

TEST(Usage, NoPathIsEmpty) {
  expect_failure(call({"run", "log", "-o", ""}), 2, "--output");
  expect_failure(call({"build", "log", "-o", ""}), 2, "--output");
  expect_failure(call({"run", ""}), 2, "LOG");
}

TEST(Usage, NoFileIsWrittenOverAnother) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog).string();
  const auto link = (folder.path() / "link").string();
  const auto other = (folder.path() / "other").string();
  std::filesystem::create_symlink("log.g2o", link);
  for (const std::string command : {"build", "solve", "join"}) {
    expect_failure(call({command, log, "-o", link}), 2, "--output are one file, " + link);
    expect_failure(call({command, log, "-o", other, "--report", folder.path().string() + "/./other"}), 2, "--report");
  }
  expect_failure(call({"run", log, "--report", log}), 2, "LOG and --report are one file");
  expect_failure(call({"run", log, "-o", other, "--report", other + "/map.g2o"}), 2, "is of the files that --output replaces");
  expect_failure(call({"simulate", "-o", other, "--truth", other}), 2, "--truth");
  EXPECT_EQ(content_of(log), kSmallLog);
  EXPECT_FALSE(std::filesystem::exists(other));
  EXPECT_EQ(call({"solve", log, "-o", "/dev/null", "--report", "/dev/null"}).exit_code, 0);
}

TEST(Usage, NoInputIsWhatAnOutputIsUntilItIsDone) {
  const TemporaryFolder folder;
  const std::string map = (folder.path() / "map.g2o").string();
  const std::string unfinished = folder.file("map.g2o.mapjoin-tmp", kSmallLog).string();
  expect_failure(call({"solve", unfinished, "-o", map}), 2,
                 "LOG " + unfinished + " is what --output is until it is done: give it another name");
  expect_failure(call({"solve", map, "--truth", unfinished, "-o", map}), 2, "--truth " + unfinished);
  const std::string out = (folder.path() / "out").string();
  for (const std::string name : {"/.mapjoin-tmp", "/.mapjoin-tmp/log.g2o", ".mapjoin-tmp/log.g2o"}) {
    expect_failure(call({"run", out + name, "-o", out + "/"}), 2, "LOG " + out + name + " is what --output is");
  }
  const std::string hard = (folder.path() / "hard.g2o").string();
  std::filesystem::create_hard_link(unfinished, hard);
  expect_failure(call({"solve", hard, "-o", map}), 2, "LOG " + hard + " is what --output is until it is done");
  const std::string store = folder.file("w.maps.partial", kSmallLog).string();
  const std::string link = (folder.path() / "link.maps").string();
  std::filesystem::create_symlink("w.maps", link);
  expect_failure(call({"build", store, "-o", (folder.path() / "w.maps").string()}), 2,
                 "LOG|MAPS " + store + " is what --output is until it is done");
  expect_failure(call({"convert", store, (folder.path() / "w.maps").string()}), 2,
                 "IN " + store + " is what OUT is until it is done");
  expect_failure(call({"build", store, "-o", link}), 2, "LOG|MAPS " + store + " is what --output is until it is done");
  ProcessOptions there;
  there.working_folder = folder.path();
  expect_failure(call({"solve", "map.g2o.mapjoin-tmp", "-o", "map.g2o"}, there), 2, "is what --output is until it is done");
  expect_failure(call({"solve", unfinished, "-o", "new.g2o", "--report", "./new.g2o"}, there), 2, "are one file, ./new.g2o");
  EXPECT_EQ(content_of(unfinished), kSmallLog);
  EXPECT_EQ(content_of(store), kSmallLog);
}

TEST(Usage, ALinkToWhatIsYetToComeIsThatFile) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog).string();
  const std::string map = (folder.path() / "map.g2o").string();
  const std::string link = (folder.path() / "link.g2o").string();
  std::filesystem::create_symlink("map.g2o", link);
  expect_failure(call({"solve", log, "-o", link, "--report", map}), 2, "--output and --report are one file");
}

TEST(Usage, NothingOfAFolderThatIsReadIsWrittenOver) {
  const TemporaryFolder folder;
  const std::string result = (folder.path() / "result").string();
  ASSERT_EQ(call({"run", kBundledLog, "-o", result, "--covariances"}).exit_code, 0);
  const std::string map = result + "/map.g2o";
  const std::string report = result + "/report.json";
  const std::string before = content_of(report);
  expect_failure(call({"plot", result, "-o", report}), 2, "MAP and --output are one file, " + report);
  expect_failure(call({"covariance", result, "5", "--report", report}), 2, "MAP and --report are one file, " + report);
  expect_failure(call({"error", result, kBundledTruth, "--report", report}), 2, "MAP and --report are one file, " + report);
  const std::string picture = (folder.path() / "picture.svg").string();
  std::filesystem::create_symlink(map, picture);
  expect_failure(call({"plot", result, "-o", picture}), 2, "MAP and --output are one file, " + picture);
  EXPECT_EQ(content_of(report), before);
  EXPECT_EQ(call({"plot", result, "-o", result + "/map.svg"}).exit_code, 0);
  const std::string replaces = " is of the files that --output replaces: give it another name, or --output another folder";
  expect_failure(call({"run", map, "-o", result}), 2, "LOG " + map + replaces);
  const std::string link = (folder.path() / "link").string();
  std::filesystem::create_symlink(map, link);
  expect_failure(call({"run", link, "-o", result}), 2, "LOG " + link + replaces);
  std::filesystem::copy(map, result + "/inliers.g2o");  // as --robust leaves it; a run without would take it away
  expect_failure(call({"run", result + "/inliers.g2o", "-o", result}), 2, "LOG " + result + "/inliers.g2o" + replaces);
  const std::string truth = result + "/trajectory_1.tum";
  std::filesystem::copy(result + "/trajectory.tum", truth);
  expect_failure(call({"run", kBundledLog, "--truth", truth, "-o", result}), 2, "--truth " + truth + replaces);
  expect_failure(call({"run", kBundledLog, "--report", truth, "-o", result}), 2, "--report " + truth + replaces);
  std::filesystem::rename(truth, result + "/trajectory_a.tum");
  EXPECT_EQ(call({"run", kBundledLog, "--truth", result + "/trajectory_a.tum", "-o", result}).exit_code, 0);
  std::filesystem::create_directory(result + "/other");
  std::filesystem::copy(map, result + "/other/map.g2o");
  EXPECT_EQ(call({"run", kBundledLog, "--truth", result + "/other/map.g2o", "-o", result}).exit_code, 0);
  EXPECT_EQ(call({"run", map, "--truth", result + "/other/map.g2o", "-o", result + "/new"}).exit_code, 0) << "of one name";
  std::filesystem::create_directory(result + "/part_2");
  std::filesystem::copy(map, result + "/part_2/map.g2o");
  expect_failure(call({"run", result + "/part_2/map.g2o", "--parts", "all", "-o", result}), 2, replaces);
}

TEST(Errors, ARemedyThatACommandLacksIsOfferedWithTheCommandThatHasIt) {
  const TemporaryFolder folder;
  const auto apart = folder.file("log.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\n").string();
  const std::string remedy = "; --parts largest takes the largest, --parts all makes a map of each";
  EXPECT_THAT(call({"run", apart}).err, EndsWith(remedy + "\n"));
  EXPECT_THAT(call({"basin", apart}).err, EndsWith(remedy + "; --parts goes with `mapjoin run`\n"));
  const auto unknown = folder.file("unknown.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nSOMETHING 1\n").string();
  const std::string map = (folder.path() / "map.tum").string();
  EXPECT_THAT(call({"solve", unknown}).err, EndsWith("; --skip-unknown leaves such lines out\n"));
  EXPECT_THAT(call({"plot", unknown, "-o", map}).err,
              EndsWith("; --skip-unknown leaves such lines out; --skip-unknown goes with `mapjoin run`\n"));
}

TEST(Usage, AStartIsForTheBatchSchedule) {
  expect_failure(call({"solve", "log.g2o", "-o", "map", "--start", "zero", "--schedule", "tree"}), 2, "--start");
}

TEST(Usage, TheWeightsOfAStoreAreThoseItWasBuiltWith) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog);
  const std::string store = (folder.path() / "maps").string();
  const std::string map = (folder.path() / "map.g2o").string();
  ASSERT_EQ(call({"build", log.string(), "-o", store}).exit_code, 0);
  expect_failure(call({"join", store, "-o", map, "--covariance", "identity"}), 2, "build");
  expect_failure(call({"join", store, "-o", map, "--repair-information"}), 2, "build");
  expect_failure(call({"info", store, "--covariance", "identity"}), 2, "build");
}

TEST(Usage, LocalMapsAreNotBuiltAgain) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog);
  const std::string store = (folder.path() / "maps").string();
  const std::string again = (folder.path() / "again").string();
  ASSERT_EQ(call({"build", log.string(), "-o", store}).exit_code, 0);
  expect_failure(call({"build", store, "-o", again}), 2, "maps: is a store already");
  expect_failure(call({"build", store, "-o", again, "--poses-per-map", "5"}), 2, "--poses-per-map");
  EXPECT_FALSE(std::filesystem::exists(again));
}

}  // namespace
}  // namespace mapjoin::testing
