// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <tests/apps/command.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class BasinCommand : public ::testing::Test {
 protected:
  BasinCommand() { std::ofstream(path("log.g2o")) << kSmallLog; }
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  Ended basin(std::vector<std::string> more) const {
    more.insert(more.begin(), {"basin", path("log.g2o"), "--poses-per-map", "2", "--seeds", "2"});
    return call(std::move(more));
  }
  TemporaryFolder folder;
};

TEST_F(BasinCommand, WritesATableForPeopleAndFilesForPrograms) {
  const Ended ended = basin({"-o", path("out")});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("original    full SLAM, absolute"));
  EXPECT_THAT(ended.out, HasSubstr("2 of 2 ("));
  const std::string csv = bytes_of(path("out/basin.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * 4 * 2 * (1 + 1 + 2));
  const json report = json::parse(bytes_of(path("out/basin.json")));
  EXPECT_EQ(report["command"], "basin");
  EXPECT_EQ(report["cells"].size(), 2U * 4 * 2 * 3);
  const json& cell = report["cells"][0];
  EXPECT_EQ(cell["problem"], "full_slam");
  EXPECT_EQ(cell["runs"][0]["ends"], "optimum");
  EXPECT_NEAR(cell["runs"][0]["chi2"].get<double>(), report["best_chi2"]["original"].get<double>(), 1e-6);
}

TEST_F(BasinCommand, GivesTheSameBytesForAnyNumberOfThreads) {
  ASSERT_EQ(basin({"-o", path("one"), "--jobs", "1"}).exit_code, 0);
  ASSERT_EQ(basin({"-o", path("two"), "--jobs", "2"}).exit_code, 0);
  EXPECT_EQ(bytes_of(path("one/basin.csv")), bytes_of(path("two/basin.csv")));
}

TEST_F(BasinCommand, TakesTheMapsOfAStoreAsTheyWereCut) {
  ASSERT_EQ(call({"build", path("log.g2o"), "-o", path("log.maps"), "--poses-per-map", "2", "--quiet"}).exit_code, 0);
  const json report = report_of({"basin", path("log.maps"), "--seeds", "1"});
  EXPECT_EQ(report["cells"].size(), 2U * 4 * 2 * 3);
  EXPECT_TRUE(report["cells"][23]["local_maps"].is_null());
  EXPECT_EQ(report["cells"][0]["maps"], 0);
  EXPECT_GT(report["cells"][23]["maps"], 0);
  EXPECT_EQ(call({"basin", path("log.maps"), "--poses-per-map", "3"}).exit_code, 2);
}

TEST_F(BasinCommand, SaysWhereThereIsNoLocalMapToJoin) {
  const std::string note =
      "note         maps of auto: this cuts the log into no local map, so that joining is full SLAM once more; another "
      "--poses-per-map N may cut it";
  const std::string short_drive = path("short.g2o");
  ASSERT_EQ(call({"simulate", "--poses", "60", "--seed", "2", "-o", short_drive, "--quiet"}).exit_code, 0);
  EXPECT_THAT(call({"basin", short_drive, "--seeds", "1"}).out, HasSubstr(note));
  EXPECT_THAT(call({"convexity", short_drive, "--pairs", "1"}).out, HasSubstr(note));
  EXPECT_EQ(report_of({"convexity", short_drive, "--pairs", "1"})["formulations"][2]["maps"], 0);
  EXPECT_THAT(call({"basin", short_drive, "--seeds", "1", "--poses-per-map", "20"}).out, Not(HasSubstr("no local map")));
}

TEST_F(BasinCommand, SaysWhichLengthsOfMapsMakeNoSense) {
  for (const std::string wrong : {"0", "3,,4", "ten", "", "5;6", "5,"}) {
    const Ended ended = call({"basin", path("log.g2o"), "--poses-per-map", wrong});
    EXPECT_EQ(ended.exit_code, 2) << wrong;
    EXPECT_THAT(ended.err, HasSubstr("--poses-per-map"));
  }
}

TEST_F(BasinCommand, NeverWritesOverItsInput) {
  const Ended ended = call({"basin", path("log.g2o"), "--report", path("log.g2o")});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_EQ(bytes_of(path("log.g2o")), kSmallLog);
}

}  // namespace
}  // namespace mapjoin::testing
