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

class ConvexityCommand : public ::testing::Test {
 protected:
  ConvexityCommand() { std::ofstream(path("log.g2o")) << kSmallLog; }
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  Ended convexity(std::vector<std::string> more) const {
    more.insert(more.begin(), {"convexity", path("log.g2o"), "--poses-per-map", "2", "--pairs", "2", "--points", "11"});
    return call(std::move(more));
  }
  TemporaryFolder folder;
};

TEST_F(ConvexityCommand, WritesATableForPeopleAndFilesForPrograms) {
  const Ended ended = convexity({"-o", path("out")});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  for (const std::string words : {"full SLAM, absolute", "joining, relative", "bounding box of the composed start", "seed 1"}) {
    EXPECT_THAT(ended.out, HasSubstr(words));
  }
  const std::string csv = bytes_of(path("out/curves.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 4 * 2 * 11);
  const json report = json::parse(bytes_of(path("out/convexity.json")));
  EXPECT_EQ(report["command"], "convexity");
  EXPECT_EQ(report["states"], "box");
  ASSERT_EQ(report["formulations"].size(), 4U);
  const json& joining = report["formulations"][3];
  EXPECT_EQ(joining["formulation"], "joining");
  EXPECT_EQ(joining["state"], "relative");
  EXPECT_EQ(joining["pairs"].size(), 2U);
  // Three poses and a feature: two edges of odometry, the first observation, and the second, of which nothing is linear.
  EXPECT_EQ(report["formulations"][1]["quadratic"]["rows"], 10);
  EXPECT_EQ(report["formulations"][1]["quadratic"]["quadratic_rows"], 8);
  // The first edge and the first observation are from the held pose, and linear; of the other edge the heading is.
  EXPECT_EQ(report["formulations"][0]["quadratic"]["quadratic_rows"], 6);
}

TEST_F(ConvexityCommand, GivesTheSameBytesForAnyNumberOfThreads) {
  for (const std::string states : {"box", "drift"}) {
    ASSERT_EQ(convexity({"-o", path("one"), "--jobs", "1", "--states", states}).exit_code, 0);
    ASSERT_EQ(convexity({"-o", path("two"), "--jobs", "2", "--states", states}).exit_code, 0);
    EXPECT_EQ(bytes_of(path("one/curves.csv")), bytes_of(path("two/curves.csv"))) << states;
  }
}

TEST_F(ConvexityCommand, TakesTheMapsOfAStoreAsTheyWereCut) {
  ASSERT_EQ(call({"build", path("log.g2o"), "-o", path("log.maps"), "--poses-per-map", "2", "--quiet"}).exit_code, 0);
  EXPECT_EQ(report_of({"convexity", path("log.maps")})["formulations"].size(), 4U);
  const Ended cut = call({"convexity", path("log.maps"), "--poses-per-map", "3"});
  EXPECT_EQ(cut.exit_code, 2);
  EXPECT_THAT(cut.err, HasSubstr("local maps are cut already"));
}

TEST_F(ConvexityCommand, EndsAtTheBestEstimateWhereAsked) {
  const json report = report_of({"convexity", path("log.g2o"), "--states", "drift", "--to-best"});
  const json& full = report["formulations"][0];
  EXPECT_NEAR(full["pairs"][0]["F_Y"].get<double>(), full["first_step"]["best_chi2"].get<double>(), 1e-9);
  EXPECT_GT(full["pairs"][0]["F_X"].get<double>(), full["pairs"][0]["F_Y"].get<double>());
}

TEST_F(ConvexityCommand, RefusesWhatMakesNoSense) {
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--pairs", "0"},
                                                {"--points", "2"},
                                                {"--spread", "0"},
                                                {"--spread", "2"},
                                                {"--states", "far"},
                                                {"--points", "many"}}) {
    const Ended ended = convexity(wrong);
    EXPECT_EQ(ended.exit_code, 2) << wrong.front();
    EXPECT_THAT(ended.err, HasSubstr(wrong.front()));
  }
  EXPECT_EQ(call({"convexity", path("none.g2o")}).exit_code, 3);
  std::ofstream(path("apart.g2o")) << "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\n";
  EXPECT_EQ(call({"convexity", path("apart.g2o")}).exit_code, 3);
  EXPECT_EQ(convexity({"-o", "/proc/none"}).exit_code, 5);
}

}  // namespace
}  // namespace mapjoin::testing
