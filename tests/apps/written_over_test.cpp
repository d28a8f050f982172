// SPDX-License-Identifier: BSD-3-Clause
// Outputs replace neither inputs nor each other.
#include <gtest/gtest.h>

#include <filesystem>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

TEST(WrittenOver, NoFileReplacesAnother) {
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

TEST(WrittenOver, NoInputIsWhatAnOutputIsUntilItIsDone) {
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
  expect_failure(call({"build", map, "-o", link, "--report", store}), 2, "--report " + store + " is what --output is");
  expect_failure(call({"run", map, "-o", out, "--report", out + "/.mapjoin-tmp/report"}), 2, "is what --output is");
  expect_failure(call({"run", map, "-o", out, "--follow", "--steps", out + "/.mapjoin-tmp/steps"}), 2, "--steps " + out);
  const std::string part = out + "/part_2/.mapjoin-tmp/log.g2o";
  std::filesystem::create_directories(out + "/part_2/.mapjoin-tmp");
  expect_failure(call({"run", part, "-o", out, "--parts", "all"}), 2, "LOG " + part + " is what --output is");
  const std::string other = (folder.path() / "other.g2o").string();
  EXPECT_EQ(call({"solve", unfinished, "-o", other, "--report", other + ".mapjoin-tmp.json"}).exit_code, 0) << "another place";
  ProcessOptions there;
  there.working_folder = folder.path();
  expect_failure(call({"solve", "map.g2o.mapjoin-tmp", "-o", "map.g2o"}, there), 2, "is what --output is until it is done");
  expect_failure(call({"solve", unfinished, "-o", "new.g2o", "--report", "./new.g2o"}, there), 2, "are one file, ./new.g2o");
  EXPECT_EQ(content_of(unfinished), kSmallLog);
  EXPECT_EQ(content_of(store), kSmallLog);
}

TEST(WrittenOver, AConvertedStoreIsKnownByItsFormatNotByItsName) {
  const TemporaryFolder folder;
  const std::string log = folder.file("out.partial", kSmallLog).string();
  const std::string out = (folder.path() / "out").string();
  expect_failure(call({"convert", log, out, "--to", "store"}), 2, "IN " + log + " is what OUT is until it is done");
  EXPECT_EQ(content_of(log), kSmallLog);
  const std::string store = folder.file("q.maps.partial", kSmallLog).string();
  const std::string map = (folder.path() / "q.maps").string();
  EXPECT_EQ(call({"convert", store, map, "--to", "g2o"}).exit_code, 0) << "no store is written";
}

TEST(WrittenOver, ALinkToWhatIsYetToComeIsThatFile) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog).string();
  const std::string map = (folder.path() / "map.g2o").string();
  const std::string link = (folder.path() / "link.g2o").string();
  std::filesystem::create_symlink("map.g2o", link);
  expect_failure(call({"solve", log, "-o", link, "--report", map}), 2, "--output and --report are one file");
}

TEST(WrittenOver, NothingReadInAFolderIsReplaced) {
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
  std::filesystem::copy(map, result + "/inliers.g2o");  // as --robust writes it; a run without it would remove it
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
  EXPECT_EQ(count_of(call({"run", result, "-o", result}).err, replaces), 1U);
  expect_failure(call({"run", kBundledLog, "--truth", result, "-o", result}), 2, replaces);
}

}  // namespace
}  // namespace mapjoin::testing
