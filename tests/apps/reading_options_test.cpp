// SPDX-License-Identifier: BSD-3-Clause
// Options that say how a log is read, where the input has no place for them.
#include <gtest/gtest.h>

#include <tests/apps/command.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using Words = std::vector<std::string>;

class ReadingOptions : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  TemporaryFolder folder;
  const std::string log = folder.file("log.g2o", kSmallLog).string();
};

TEST_F(ReadingOptions, AreRefusedForLocalMapsByEveryCommand) {
  const std::string maps = path("log.maps");
  ASSERT_EQ(call({"build", log, "-o", maps, "--quiet"}).exit_code, 0);
  const std::vector<Words> commands = {{"check", maps}, {"covariance", maps, "0"}, {"convert", maps, path("again.g2o")}};
  const std::vector<Words> options = {
      {"--g2o-error", "paper"}, {"--g2o-error", "g2o"}, {"--from", "g2o"}, {"--skip-undeclared"}};
  for (const Words& option : options) {
    for (Words words : commands) {
      words.insert(words.end(), option.begin(), option.end());
      expect_failure(call(words), 2, "log.maps: holds local maps, and " + option.front() + " is for a log");
    }
  }
  expect_failure(call({"info", maps, "--ids-are-nanoseconds"}), 2, "--ids-are-nanoseconds is for a log");
}

TEST_F(ReadingOptions, OfG2oAreRefusedForOtherFormats) {
  ASSERT_EQ(call({"convert", log, path("log.isam"), "--quiet"}).exit_code, 0);
  expect_failure(call({"run", path("log.isam"), "--rotation-information", "quaternion"}), 2,
                 "log.isam: is not in g2o, for which --g2o-error and --rotation-information are");
}

TEST_F(ReadingOptions, ThatLeaveLinesOutHoldForTheTruth) {
  const std::string truth = folder.file("truth.g2o", "VERTEX_SE2 0 0 0 0\nSCAN 1\nVERTEX_SE2 1 1 0 0\n").string();
  const std::string map = folder.file("map.csv", "pose,x,y,phi\n0,0,0,0\n1,1,0,0\n").string();
  const Words words = {"error", map, truth, "--skip-unknown", "--from", "csv"};
  EXPECT_EQ(report_of(words)["errors"]["ate"]["translation"]["count"], 2);
  expect_failure(call({"run", log, "--truth", truth}), 3, "unknown tag 'SCAN'");
  EXPECT_EQ(call({"run", log, "--truth", truth, "--skip-unknown", "--rotation-information", "quaternion"}).exit_code, 0);
  const std::string maps = path("truth.maps");
  ASSERT_EQ(call({"build", log, "-o", maps, "--quiet"}).exit_code, 0);
  expect_failure(call({"join", maps, "--truth", truth}), 3,
                 "truth.g2o:2:1: unknown tag 'SCAN'; --skip-unknown leaves such lines out");
  EXPECT_EQ(call({"join", maps, "--truth", truth, "--skip-unknown"}).exit_code, 0);
  expect_failure(call({"join", maps, "--skip-unknown"}), 2, "--skip-unknown is of --truth");
}

TEST_F(ReadingOptions, OfSeveralInputsAreRefusedForOne) {
  expect_failure(call({"run", log, "--features", "own"}), 2, "--features own is of several inputs");
  const std::string maps = path("log.maps");
  ASSERT_EQ(call({"build", log, "-o", maps, "--quiet"}).exit_code, 0);
  expect_failure(call({"join", maps, "--features", "own"}), 2, "inputs; inputs of one store take it from `mapjoin build`");
  expect_failure(call({"check", log, "--keep-copies"}), 2, "--keep-copies is of several inputs");
}

TEST_F(ReadingOptions, ThatLeaveLinesOutAreSaidByEveryStudy) {
  const std::string partial = folder.file("partial.g2o", kSmallLog + "SCAN 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n").string();
  for (const Words& study :
       {Words{"compare", partial, "-o", path("study")}, {"basin", partial, "--seeds", "1"}, {"convexity", partial}}) {
    Words words = study;
    words.emplace_back("--skip-unknown");
    const std::string said = call(words).out;
    EXPECT_THAT(said, ::testing::HasSubstr("note         left out: SCAN lines (1)\n")) << study.front();
    EXPECT_THAT(said, ::testing::HasSubstr("note         1 edge repeats another between the same two poses")) << study.front();
  }
  EXPECT_THAT(content_of(path("study/compare.html")), ::testing::HasSubstr("<dt>Note</dt><dd>left out: SCAN lines (1)</dd>"));
}

TEST_F(ReadingOptions, OfPartsCountTheFeaturesThatTheyLeaveOut) {
  const std::string text =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 0 0 0\nVERTEX_XY 8 1 1\nVERTEX_XY 9 1 1\n"
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 2 8 1 1 1 0 1\n";
  const std::string apart = folder.file("apart.g2o", text).string();
  expect_failure(call({"run", apart}), 3, "feature 9 is never observed; --parts largest leaves such features out");
  const auto skipped = report_of({"run", apart, "--parts", "largest"}).at("skipped");
  EXPECT_EQ(skipped.at("poses of other parts"), 1);
  EXPECT_EQ(skipped.at("features of other parts"), 1);
  EXPECT_EQ(skipped.at("features that no pose observes"), 1);
  const Ended all = call({"run", apart, "--parts", "all", "-o", path("all")});
  EXPECT_THAT(all.out, ::testing::HasSubstr("left out: features that no pose observes (1)"));
}

TEST_F(ReadingOptions, InflateStandardDeviationsByKind) {
  const std::string maps = path("inflated.maps");
  const Words option = {"--inflate", "odometry=2,observation=2"};
  const auto with = [&](Words words) {
    words.insert(words.end(), option.begin(), option.end());
    return words;
  };
  const auto given = report_of({"run", kBundledLog});
  const auto inflated = report_of(with({"run", kBundledLog}));
  EXPECT_NEAR(4.0 * inflated["chi2"].get<double>(), given["chi2"].get<double>(), 1e-6);
  EXPECT_EQ(given["convention"]["inflation"]["odometry"], 1.0);
  EXPECT_EQ(inflated["convention"]["inflation"]["odometry"], 2.0);
  EXPECT_EQ(inflated["convention"]["inflation"]["closure"], 1.0);
  ASSERT_EQ(call(with({"build", kBundledLog, "-o", maps, "--quiet"})).exit_code, 0);
  EXPECT_EQ(report_of({"join", maps})["convention"]["inflation"], inflated["convention"]["inflation"]);
  expect_failure(call({"join", maps, "--inflate", "map=2"}), 2, "--inflate and --repair-information go with `mapjoin build`");
  expect_failure(call({"join", maps, "--inflate", "closure=2"}), 2, "is for a log, from which `mapjoin build` makes them");
  ASSERT_EQ(call(with({"convert", kBundledLog, path("inflated.g2o"), "--quiet"})).exit_code, 0);
  EXPECT_NEAR(report_of({"run", path("inflated.g2o")})["chi2"].get<double>(), inflated["chi2"].get<double>(), 1e-6);
}

TEST_F(ReadingOptions, InflateLocalMapsOnce) {
  const std::string maps = path("maps");
  const std::string store = path("maps.maps");
  ASSERT_EQ(call({"build", kBundledLog, "-o", path("log.maps"), "--quiet"}).exit_code, 0);
  ASSERT_EQ(call({"convert", path("log.maps"), maps, "--to", "maps-text", "--quiet"}).exit_code, 0);
  ASSERT_EQ(call({"build", maps, "-o", store, "--inflate", "map=2", "--quiet"}).exit_code, 0);
  const double given = report_of({"join", maps})["chi2"].get<double>();
  EXPECT_NEAR(4.0 * report_of({"join", maps, "--inflate", "map=2"})["chi2"].get<double>(), given, 1e-6 * given);
  EXPECT_NEAR(4.0 * report_of({"join", store})["chi2"].get<double>(), given, 1e-6 * given);
  expect_failure(call({"join", store, "--inflate", "map=3"}), 2, "the weights of a store are chosen when it is built");
  expect_failure(call({"join", maps, "--inflate", "closure=3"}), 2, "--inflate closure is for a log, from which");
}

TEST_F(ReadingOptions, InflateOnlyWhatTheInputHas) {
  for (const char* words : {"closure", "closure=0", "closures=2", "closure=2,", "closure=nan", "=2"}) {
    expect_failure(call({"run", log, "--inflate", words}), 2, "not closure=X, odometry=X, observation=X, prior=X or map=X");
  }
  expect_failure(call({"run", log, "--inflate", "map=2"}), 2, "log.g2o: is a log, and --inflate map is for local maps");
  expect_failure(call({"run", log, "--inflate", "closure=2", "--covariance", "identity"}), 2,
                 "--inflate is of the weights as given, which --covariance identity replaces");
  expect_failure(call({"run", log, "--gps", log, "--inflate", "prior=2"}), 2, "says how certain its fixes are");
  expect_failure(call({"run", log, "--follow", "--inflate", "closure=2"}), 2, "--inflate is for a log that is complete");
  const std::string maps = path("log.maps");
  ASSERT_EQ(call({"build", log, "-o", maps, "--quiet"}).exit_code, 0);
  expect_failure(call({"check", maps, "--inflate", "odometry=2"}), 2, "--inflate odometry is for a log");
}

}  // namespace
}  // namespace mapjoin::testing
