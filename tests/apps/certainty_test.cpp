// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <map>
#include <mapjoin/geometry/pose.hpp>
#include <sstream>
#include <tests/apps/command.hpp>
#include <tests/support/temporary_folder.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Certainty : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  void simulate(const std::string& dimension, const std::string& truth) const {
    const Ended ended = call({"simulate", "--dim", dimension, "--poses", "150", "--seed", "2", "-o", path("log.g2o"), "--truth",
                              path(truth), "--quiet"});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
  }
  /// The numbers in a line of a CSV file; line 0 is the first.
  static std::vector<double> numbers(const std::string& file, int line) {
    std::ifstream in(file);
    std::string text;
    for (int k = 0; k <= line; ++k) std::getline(in, text);
    std::vector<double> values;
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) values.push_back(std::stod(word));
    return values;
  }
  TemporaryFolder folder;
};

TEST_F(Certainty, OfNothingIsUnknown) {
  const std::string edge = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
  const std::string log = folder.file("graph.g2o", edge).string();
  const json median = report_of({"run", log, "--covariances"})["certainty"]["median_deviation"];
  EXPECT_GT(median["poses"]["in_map"], 0.0);
  EXPECT_EQ(median["features"], json({{"in_map", nullptr}, {"relative", nullptr}}));
  EXPECT_THAT(call({"run", log, "--covariances"}).out, HasSubstr("to where they hang (median standard deviations)"));
  EXPECT_EQ(call({"run", log, "--covariances", "--relations"}).err,
            "mapjoin: covariances.json and relations.csv would be written with --output\n");
  const std::string all_fixed = folder.file("fixed.g2o", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nFIX 0 1\n" + edge).string();
  EXPECT_EQ(report_of({"run", all_fixed, "--covariances"})["certainty"]["median_deviation"]["poses"]["in_map"], nullptr);
}

TEST_F(Certainty, CovariancesGoIntoTheTablesAndIntoAFileOfTheirOwn) {
  simulate("2", "truth.g2o");
  ASSERT_EQ(call({"run", path("log.g2o"), "-o", path("out"), "--covariances", "--quiet"}).exit_code, 0);
  EXPECT_THAT(content_of(path("out/poses.csv")),
              StartsWith("pose,x,y,phi,cov_x_x,cov_x_y,cov_x_phi,cov_y_y,cov_y_phi,cov_phi_phi\n0,"));
  EXPECT_THAT(content_of(path("out/features.csv")), StartsWith("feature,x,y,cov_x_x,cov_x_y,cov_y_y\n"));
  const json covariances = json::parse(content_of(path("out/covariances.json")));
  EXPECT_EQ(covariances["estimate"], "polished");
  EXPECT_EQ(covariances["gauge"]["held_poses"][0]["pose"], 0);
  EXPECT_EQ(covariances["pose_coordinates"], json({"x", "y", "phi"}));
  ASSERT_EQ(covariances["poses"].size(), 150U);
  const std::vector<double> row = numbers(path("out/poses.csv"), 78);
  EXPECT_EQ(covariances["poses"][77]["pose"], 77);
  EXPECT_EQ(covariances["poses"][77]["position"], json({row[1], row[2]}));
  EXPECT_EQ(covariances["poses"][77]["covariance"], json(std::vector<double>(row.begin() + 4, row.end())));
  EXPECT_GT(row[4], 0.0);
  const json report = json::parse(content_of(path("out/report.json")));
  EXPECT_EQ(report["certainty"]["estimate"], "polished");
  EXPECT_THAT(report["files"].dump(), HasSubstr("covariances.json"));
}

TEST_F(Certainty, CovariancesOfASingleFileStandBesideIt) {
  simulate("3", "truth.g2o");
  ASSERT_EQ(call({"solve", path("log.g2o"), "-o", path("map.csv"), "--covariances", "--quiet"}).exit_code, 0);
  EXPECT_THAT(content_of(path("map.csv")), HasSubstr("qw,cov_x_x,cov_x_y,cov_x_z,cov_x_rx,"));
  const json covariances = json::parse(content_of(path("map.covariances.json")));
  EXPECT_EQ(covariances["estimate"], "polished");
  EXPECT_EQ(covariances["poses"][5]["covariance"].size(), 21U);
}

TEST_F(Certainty, RelationsAreALinePerPoseAfterItsParentAndOnePerFeature) {
  simulate("2", "truth.g2o");
  ASSERT_EQ(call({"run", path("log.g2o"), "-o", path("out"), "--relations", "--quiet"}).exit_code, 0);
  std::istringstream lines(content_of(path("out/relations.csv")));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line,
            "kind,session,id,parent_session,parent,x,y,phi,cov_x_x,cov_x_y,cov_x_phi,cov_y_y,cov_y_phi,cov_phi_phi,"
            "position_sd,position_sd_in_map,rotation_sd,rotation_sd_in_map");
  std::map<std::string, Pose<2>> poses;
  std::size_t features = 0;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream words(line + ",");
    for (std::string word; std::getline(words, word, ',');) cells.push_back(word);
    ASSERT_EQ(cells.size(), 18U) << line;
    const Pose<2> parent = cells[4].empty() ? Pose<2>{} : poses.at(cells[4]);
    const Point<2> translation(std::stod(cells[5]), std::stod(cells[6]));
    if (cells[0] == "pose") {
      poses[cells[2]] = compose(parent, {translation, Rotation<2>(std::stod(cells[7]))});
      EXPECT_NEAR(std::pow(std::stod(cells[14]), 2), std::stod(cells[8]) + std::stod(cells[11]), 1e-12);
      continue;
    }
    const std::vector<double> feature = numbers(path("out/features.csv"), static_cast<int>(++features));
    EXPECT_EQ(feature[0], std::stod(cells[2]));
    EXPECT_LT((transform(parent, translation) - Point<2>(feature[1], feature[2])).norm(), 1e-9);
    EXPECT_EQ(cells[1] + cells[7] + cells[10] + cells[17], "");
  }
  ASSERT_EQ(poses.size(), 150U);
  const std::vector<double> last = numbers(path("out/poses.csv"), 150);
  EXPECT_EQ(last.size(), 4U) << "the covariances were not asked for";
  EXPECT_LT((poses.at("149").translation - Point<2>(last[1], last[2])).norm(), 1e-9);
  const json report = json::parse(content_of(path("out/report.json")));
  EXPECT_LT(report["certainty"]["median_deviation"]["poses"]["relative"],
            report["certainty"]["median_deviation"]["poses"]["in_map"]);
}

TEST_F(Certainty, RelationsOfASingleFileStandBesideIt) {
  simulate("3", "truth.g2o");
  ASSERT_EQ(call({"solve", path("log.g2o"), "-o", path("map.g2o"), "--relations", "--quiet"}).exit_code, 0);
  const std::string relations = content_of(path("map.relations.csv"));
  EXPECT_THAT(relations, HasSubstr(",qw,cov_x_x,"));
  EXPECT_THAT(relations, HasSubstr("\npose,0,149,0,148,"));
}

TEST_F(Certainty, WhatAnEarlierMapLeftBesideIsSaidAndNeitherRemovedNorDrawn) {
  simulate("2", "truth.g2o");
  ASSERT_EQ(call({"solve", path("log.g2o"), "-o", path("map.g2o"), "--covariances", "--relations"}).err, "");
  const std::string relations = content_of(path("map.relations.csv"));
  ASSERT_EQ(call({"simulate", "--poses", "150", "--seed", "3", "-o", path("log.g2o")}).exit_code, 0);
  const Ended again = call({"solve", path("log.g2o"), "-o", path("map.g2o"), "--quiet"});
  EXPECT_EQ(again.exit_code, 0);
  for (const std::string name : {"map.covariances.json", "map.relations.csv"}) {
    EXPECT_THAT(again.err, HasSubstr("mapjoin: " + path(name) + ": was there before, and this call did not write it; "));
  }
  EXPECT_EQ(content_of(path("map.relations.csv")), relations);
  const Ended plotted = call({"plot", path("map.g2o"), "-o", path("map.svg")});
  EXPECT_EQ(plotted.exit_code, 3);
  EXPECT_THAT(plotted.err, HasSubstr("map.covariances.json: is not of the map beside it; remove it, or make both in one run"));
  ASSERT_EQ(call({"solve", path("log.g2o"), "-o", path("map.g2o"), "--covariances"}).exit_code, 0);
  EXPECT_EQ(call({"plot", path("map.g2o"), "-o", path("map.svg")}).exit_code, 0);
}

TEST_F(Certainty, AMapThatIsFreeToMoveIsRefusedByEveryMethod) {
  // Only one coordinate of the feature is known: the damping of Levenberg-Marquardt would hold the other, nothing else does.
  std::ofstream(path("log.g2o")) << "VERTEX_SE2 0 0 0 0.5\nVERTEX_SE2 1 1 0 0.5\nVERTEX_XY 2 3 1\nFIX 0\n"
                                    "EDGE_SE2 0 1 1 0 0 10 0 0 10 0 10\nEDGE_SE2_XY 0 2 3 1 10 0 0\n";
  for (const std::string method : {"gn", "dogleg", "lm"}) {
    const Ended ended = call({"solve", path("log.g2o"), "-o", path("map.g2o"), "--method", method, "--covariances"});
    EXPECT_EQ(ended.exit_code, 3) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("feature 2 cannot be determined: the observations leave it free to move"));
    EXPECT_FALSE(std::filesystem::exists(path("map.g2o")));
    EXPECT_FALSE(std::filesystem::exists(path("map.covariances.json")));
  }
}

TEST_F(Certainty, AStoreThatIsJoinedHasTheCovariancesOfARun) {
  simulate("2", "truth.g2o");
  ASSERT_EQ(call({"run", path("log.g2o"), "--poses-per-map", "10", "-o", path("out"), "--covariances", "--quiet"}).exit_code,
            0);
  ASSERT_EQ(call({"build", path("log.g2o"), "--poses-per-map", "10", "-o", path("maps"), "--quiet"}).exit_code, 0);
  ASSERT_EQ(call({"join", path("maps"), "-o", path("map.csv"), "--covariances", "--quiet"}).exit_code, 0);
  EXPECT_EQ(content_of(path("map.covariances.json")), content_of(path("out/covariances.json")));
}

TEST_F(Certainty, TheTruthIsAMapOrATrajectory) {
  simulate("2", "truth.g2o");
  const json whole = report_of({"run", path("log.g2o"), "--truth", path("truth.g2o")})["certainty"]["nees"];
  for (const std::string part : {"poses", "features", "joint"}) {
    EXPECT_GT(whole[part]["value"], whole[part]["least"]) << part;
    EXPECT_LT(whole[part]["value"], whole[part]["most"]) << part;
  }
  EXPECT_EQ(whole["poses"]["dimensions"], 149 * 3);
  simulate("2", "truth.tum");
  const json poses = report_of({"run", path("log.g2o"), "--truth", path("truth.tum")})["certainty"]["nees"];
  EXPECT_NEAR(poses["poses"]["value"], whole["poses"]["value"], 1e-6);
  EXPECT_TRUE(poses["features"]["value"].is_null());
  EXPECT_EQ(poses["features"]["dimensions"], 0);
}

TEST_F(Certainty, ATruthThatBeginsLaterHasErrorsButNoNees) {
  simulate("2", "truth.tum");
  std::string later;
  const auto lines = lines_of(content_of(path("truth.tum")));
  for (std::size_t k = 10; k < lines.size(); ++k) later += lines[k] + "\n";
  const std::string truth = folder.file("later.tum", later).string();
  const Ended ended = call({"run", path("log.g2o"), "--truth", truth});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out,
              HasSubstr("NEES         none: the truth lacks the pose that holds the map still, or has nothing else\nATE "));
  const std::string nowhere = folder.file("nowhere.tum", "900 0 0 0 0 0 0 1\n").string();
  const Ended other = call({"run", path("log.g2o"), "--truth", nowhere});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr(nowhere + ": has no pose or feature of " + path("log.g2o") +
                                   ", by name, time or count; leave --truth out"));
}

TEST_F(Certainty, TheTruthMayComeThroughAPipe) {
  simulate("2", "truth.tum");
  const std::string pipe = path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::jthread writer([&] { std::ofstream(pipe) << content_of(path("truth.tum")); });
  const Ended ended = call({"run", path("log.g2o"), "--truth", pipe});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("ATE          150 of 150 poses"));
}

TEST_F(Certainty, TheSummaryGivesAVerdict) {
  simulate("2", "truth.g2o");
  const Ended ended = call({"run", path("log.g2o"), "--truth", path("truth.g2o")});
  EXPECT_THAT(ended.out, HasSubstr("NEES         joint "));
  EXPECT_THAT(ended.out, HasSubstr("dimensions, consistent ("));
}

TEST_F(Certainty, ATruthInAnotherFrameThanThePriorsIsNotCalledOverconfidenceForSure) {
  const std::string prior = "EDGE_PRIOR_SE2 0 0 0 0 100 0 0 100 0 100\n";
  const std::string truth = folder.file("far.tum", "0 50 0 0 0 0 0 1\n1 51 0 0 0 0 0 1\n2 52 0 0 0 0 0 1\n").string();
  EXPECT_THAT(call({"run", folder.file("log.g2o", kSmallLog + prior).string(), "--truth", truth}).out,
              HasSubstr("over 9 dimensions, OVERCONFIDENT, unless the truth is in another frame than the map ("));
  EXPECT_THAT(call({"run", folder.file("log.g2o", kSmallLog).string(), "--truth", truth}).out,
              HasSubstr("over 6 dimensions, cautious ("))
      << "a map that one pose holds has no frame of its own";
}

TEST_F(Certainty, ATruthThatDoesNotFitIsRefused) {
  simulate("3", "space.g2o");
  simulate("2", "truth.g2o");
  const Ended other = call({"run", path("log.g2o"), "--truth", path("space.g2o")});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err,
              HasSubstr("the truth is not in 2D, as the map is; a trajectory of it (`mapjoin convert TRUTH TRUTH.tum`)"));
  ASSERT_EQ(call({"convert", path("space.g2o"), path("space.tum")}).exit_code, 0);
  EXPECT_EQ(call({"run", path("log.g2o"), "--truth", path("space.tum")}).exit_code, 0);
  const Ended no_values = call({"run", path("log.g2o"), "--truth", path("log.g2o")});
  EXPECT_EQ(no_values.exit_code, 3);
  EXPECT_EQ(call({"run", path("log.g2o"), "--truth", path("nowhere.tum")}).exit_code, 3);
}

TEST_F(Certainty, TooMuchMemoryIsRefusedAndNothingIsWritten) {
  simulate("2", "truth.g2o");
  const Ended ended = call({"run", path("log.g2o"), "-o", path("out"), "--covariances", "--max-memory", "0.01"});
  EXPECT_EQ(ended.exit_code, 6);
  EXPECT_THAT(ended.err, HasSubstr("more than the 0.01 MB allowed"));
  EXPECT_FALSE(std::filesystem::exists(path("out")));
  EXPECT_THAT(call({"run", path("log.g2o"), "--max-memory", "1"}).err,
              HasSubstr("--max-memory is of --covariances, --relations and --truth"));
  for (const std::string none : {"0", "-1", "1e-9", "much"}) {
    const Ended refused = call({"run", path("log.g2o"), "--covariances", "--max-memory", none});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr("--max-memory is \"" + none + "\", not a number from 1e-06 on"));
  }
}

TEST_F(Certainty, EveryLocalMapSaysHowItFits) {
  simulate("2", "truth.g2o");
  const json report = report_of({"run", path("log.g2o"), "--poses-per-map", "10"});
  ASSERT_EQ(report["join"]["maps"].size(), report["local_maps"]["count"]);
  double chi2 = 0.0;
  for (const json& map : report["join"]["maps"]) {
    chi2 += map["chi2"].get<double>();
    EXPECT_GT(map["probability"], 1e-6);
    EXPECT_LE(map["probability"], 1.0);
  }
  EXPECT_NEAR(chi2, report["join"]["chi2"], 1e-6 * chi2);  // there is nothing but maps to join
}

}  // namespace
}  // namespace mapjoin::testing
