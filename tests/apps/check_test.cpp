// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <tests/apps/command.hpp>
#include <tests/support/data.hpp>

namespace mapjoin::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

json checked(std::vector<std::string> arguments, int exit_code) {
  arguments.insert(arguments.begin(), "check");
  arguments.insert(arguments.end(), {"--report", "-"});
  const Ended ended = call(arguments);
  EXPECT_EQ(ended.exit_code, exit_code) << ended.err << ended.out;
  return json::parse(ended.out);
}

/// The finding of this name; null if there is none.
json finding(const json& report, const std::string& check) {
  for (const json& finding : report["findings"]) {
    if (finding["check"] == check) return finding;
  }
  return nullptr;
}

TEST(Check, HasNothingToSayOfTheBundledLogs) {
  for (const char* log : {"manhattan2d.g2o", "manhattan3d.g2o"}) {
    const Ended ended = call({"check", (kBundledData / log).string()});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("nothing to warn of"));
    EXPECT_THAT(ended.out, Not(HasSubstr("warning")));
  }
}

TEST(Check, WeighsResidualsAtTheJoinedMap) {
  const std::string log = kBundledLog;
  const json report = checked({log}, 0);
  double chi2 = 0.0;
  for (const json& fit : report["fits"]) chi2 += fit["chi2"].get<double>();
  EXPECT_NEAR(chi2, 4702.179445, 1e-5);
  EXPECT_EQ(report["chi2"], chi2);
  EXPECT_EQ(report["dof"], 4762);
  EXPECT_EQ(report["estimate"], "joined");
  EXPECT_TRUE(checked({log, "--estimate", "none"}, 0)["fits"].empty());
}

TEST(Check, NamesTheFirstThreePlacesForPeople) {
  const TemporaryFolder folder;
  std::string log;
  for (int pose = 0; pose < 5; ++pose) {
    for (int twice = 0; twice < 2; ++twice) log += fmt::format("EDGE_SE2 {} {} 1 0 0 1 0 0 1 0 1\n", pose, pose + 1);
  }
  EXPECT_THAT(call({"check", folder.file("log.g2o", log).string()}).out,
              HasSubstr("pose 0 to pose 1, pose 1 to pose 2, pose 2 to pose 3 and 2 more\n"));
}

TEST(Check, NamesAsManyPlacesAsAskedFor) {
  const TemporaryFolder folder;
  std::string text = kSmallLog;
  for (int feature = 100; feature < 140; ++feature) text += fmt::format("EDGE_SE2_XY 1 {} 1 1 1 0 1\n", feature);
  const std::string log = folder.file("log.g2o", text).string();
  EXPECT_THAT(call({"check", log, "--most", "30"}).out, HasSubstr("feature 129 and 10 more\n"));
  EXPECT_THAT(call({"check", log, "--most", "all"}).out, HasSubstr(", feature 139\n"));
  const auto findings = nlohmann::json::parse(call({"check", log, "--report", "-"}).out)["findings"];
  const auto once = std::ranges::find_if(findings, [](const auto& finding) { return finding["check"] == "seen_once"; });
  EXPECT_EQ((*once)["count"], 40);
  EXPECT_EQ((*once)["where"].size(), 20U);
}

TEST(Check, NamesWhatIsOutOfLineAsOftenAsAskedFor) {
  const TemporaryFolder folder;
  std::string text = content_of(kBundledLog);
  for (const char* closure :
       {"EDGE_SE2 10 14 1 0 0", "EDGE_SE2 300 305 2 1 0", "EDGE_SE2 600 603 0 0 0", "EDGE_SE2 800 804 9 0 0"}) {
    text += std::string(closure) + " 25 0 0 25 0 25\n";
  }
  const std::string log = folder.file("log.g2o", text).string();
  const std::string csv = (folder.path() / "misfits.csv").string();
  const Ended all = call({"check", log, "--most", "all", "-o", csv});
  EXPECT_EQ(all.exit_code, 1) << all.err;
  EXPECT_THAT(all.out, HasSubstr("warning      out of line with the rest: 4 of 3526 measurements\n"));
  for (const char* name : {"closure from pose 10 to pose 14 (", "closure from pose 300 to pose 305 (",
                           "closure from pose 600 to", "closure from pose 800 to"}) {
    EXPECT_THAT(all.out, HasSubstr(name));
  }
  EXPECT_THAT(call({"check", log}).out, HasSubstr(" and 1 more\n"));
  const std::string lines = content_of(csv);
  EXPECT_EQ(std::ranges::count(lines, '\n'), 5);
  EXPECT_THAT(lines, HasSubstr("kind,from_session,from,to_session,to,chi2,rows,probability\n"));
  EXPECT_THAT(lines, HasSubstr("\nclosure,0,800,0,804,"));
  for (const char* most : {"two", "0"}) EXPECT_EQ(call({"check", log, "--most", most}).exit_code, 2);
  EXPECT_EQ(call({"check", log, "-o", csv, "--estimate", "none"}).exit_code, 2);
}

TEST(Check, SaysWhereNothingCanBeTestedAndWherePositionsAreUnknown) {
  const TemporaryFolder folder;
  std::string text;
  for (int k = 0; k < 100; ++k) text += "EDGE_SE2 " + std::to_string(k) + ' ' + std::to_string(k + 1) + " 1 0 0 1 0 0 1 0 1\n";
  const json report = checked({folder.file("log.g2o", text).string()}, 1);
  EXPECT_EQ(report["verdict"], "untested");
  EXPECT_THAT(finding(report, "untested")["text"].get<std::string>(), HasSubstr("nothing is measured twice"));
  EXPECT_EQ(finding(report, "uncertain")["level"], "warning");
  EXPECT_THAT(finding(report, "uncertain")["text"].get<std::string>(), HasSubstr("(pose 100) in a map of 100 m"));
}

TEST(Check, NamesAFeatureOfUnknownPosition) {
  const TemporaryFolder folder;
  const json report = checked({folder.file("log.g2o", kSmallLog + "EDGE_SE2_XY 1 9 1 1 1 0 0.0001\n").string()}, 1);
  EXPECT_EQ(finding(report, "uncertain")["level"], "warning");
  EXPECT_THAT(finding(report, "uncertain")["text"].get<std::string>(), HasSubstr("100 m (feature 9) in a map of "));
}

TEST(Check, EndsWithOneWhereThereIsSomethingToLookAt) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  const json copies = finding(checked({log.string()}, 1), "copies");
  EXPECT_EQ(copies["level"], "warning");
  EXPECT_EQ(copies["count"], 1);
  EXPECT_EQ(copies["where"], json({"pose 0 to pose 1"}));
}

TEST(Check, ReportsALogThatFallsApartInsteadOfRefusingIt) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog + "EDGE_SE2 8 9 1 0 0 1 0 0 1 0 1\n");
  const json report = checked({log.string()}, 1);
  EXPECT_EQ(finding(report, "parts")["level"], "error");
  EXPECT_EQ(report["chi2"], nullptr);
  EXPECT_EQ(report["dof"], nullptr);
  EXPECT_EQ(finding(report, "undetermined"), nullptr) << "nothing is joined";
}

TEST(Check, ReportsALogThatFallsApartWithRobustToo) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog + "EDGE_SE2 8 9 1 0 0 1 0 0 1 0 1\n");
  const json report = checked({log.string(), "--robust"}, 1);
  EXPECT_EQ(finding(report, "parts")["where"], json({"pose 0", "pose 8"}));
  EXPECT_EQ(report["robust"], nullptr) << "nothing is judged";
}

TEST(Check, SaysThatATrajectoryIsNoLog) {
  const TemporaryFolder folder;
  const std::string poses = folder.file("poses.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n").string();
  const std::string said = "has poses, but no edges: a trajectory or a map without them, not a log; `mapjoin plot`, ";
  EXPECT_THAT(finding(checked({poses}, 1), "parts")["text"].get<std::string>(), HasSubstr(said));
  for (const auto& words : std::vector<std::vector<std::string>>{{"run", poses},
                                                                 {"solve", poses},
                                                                 {"covariance", poses, "0"},
                                                                 {"build", poses, "-o", (folder.path() / "maps").string()}}) {
    expect_failure(call(words), 3, said);
  }
}

TEST(Check, ReportsWhatTheNumbersLeaveUndetermined) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  EXPECT_THAT(finding(checked({log.string()}, 1), "undetermined")["text"].get<std::string>(), HasSubstr("pose"));
}

TEST(Check, TakesTheFilesOwnValuesWhereAskedTo) {
  const TemporaryFolder folder;
  const std::string map = (folder.path() / "map.g2o").string();
  ASSERT_EQ(call({"solve", kBundledLog, "-o", map}).exit_code, 0);
  EXPECT_TRUE(checked({map, "--estimate", "file"}, 0)["findings"].size() == 1);  // a feature is seen once
  std::string text = content_of(map);
  const std::string vertex = "VERTEX_SE2 500 ";
  text.insert(text.find(vertex) + vertex.size(), "100");  // moved by a hundred metres or more
  const json moved = checked({folder.file("moved.g2o", text).string(), "--estimate", "file"}, 1);
  EXPECT_THAT(finding(moved, "outliers")["where"][0].get<std::string>(), HasSubstr("pose 500"));
  const Ended without = call({"check", folder.file("bare.g2o", kSmallLog).string(), "--estimate", "file"});
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.err, HasSubstr("no values"));
}

TEST(Check, CountsTheSameFreedomAtEitherMapThatPriorsHold) {
  const TemporaryFolder folder;
  const std::string map = (folder.path() / "map.g2o").string();
  const auto log = folder.file("log.g2o", kSmallLog + "EDGE_PRIOR_SE2_XY 0 0 0 1 0 1\nEDGE_PRIOR_SE2_XY 2 2 0 1 0 1\n");
  ASSERT_EQ(call({"solve", log.string(), "-o", map}).exit_code, 0);
  const auto dof_at = [&](const std::string& estimate) {
    return json::parse(call({"check", map, "--estimate", estimate, "--report", "-"}).out)["dof"];
  };
  EXPECT_EQ(dof_at("file"), dof_at("joined"));
  EXPECT_EQ(dof_at("joined"), 3);  // rows: odometry 6, observations 4, priors 4; unknowns: 9 of poses, 2 of the feature
}

TEST(Check, SaysWhatWasRepairedAndLeftOut) {
  const TemporaryFolder folder;
  const std::string dirt = "FOO 1\nEDGE_SE2 1 1 0 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 1 7 1 1\nEDGE_SE2_XY 0 7 2 1 1 2 1\n";
  const std::string out = call({"check", folder.file("log.g2o", kSmallLog + dirt).string(), "--skip-unknown",
                                "--skip-self-edges", "--identity-where-missing", "--repair-information"})
                              .out;
  EXPECT_THAT(out, HasSubstr("note         1 indefinite information matrix was replaced by the nearest semidefinite one\n"));
  EXPECT_THAT(out, HasSubstr("note         1 edge without weights got the identity\n"));
  EXPECT_THAT(out, HasSubstr("note         left out: FOO lines (1), self-edges (1)\n"));
}

TEST(Check, CannotReadWhatIsNoLog) {
  const TemporaryFolder folder;
  EXPECT_EQ(call({"check", folder.file("log.g2o", "EDGE_SE2 0 1 nan\n").string()}).exit_code, 3);
}

TEST(Check, ChecksStoresAndWritesItsReportBesideTheSummary) {
  const TemporaryFolder folder;
  const std::string store = (folder.path() / "maps").string();
  const std::string report = (folder.path() / "report.json").string();
  ASSERT_EQ(call({"build", kBundledLog, "-o", store, "--poses-per-map", "50"}).exit_code, 0);
  const Ended ended = call({"check", store, "--report", report});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("odometry: "));
  EXPECT_EQ(json::parse(content_of(report))["poses"], 1000);
}

TEST(CheckData, FindsWhatIsKnownOfPublicData) {
  const json vicpark = checked({data_file("vicpark-6898/vicpark6898.g2o.gz").string()}, 1);
  EXPECT_TRUE(finding(vicpark, "too_cautious").is_object());
  EXPECT_EQ(vicpark["findings"].size(), 1u);

  // The misfits of DLR are associations that its corrected log mends.
  const json dlr = checked({data_file("dlr/map.circles.gz").string()}, 1);
  const json corrected = checked({data_file("dlr/dlr_corrected.txt.gz").string()}, 1);
  EXPECT_THAT(finding(dlr, "misfit")["where"][0].get<std::string>(), HasSubstr("feature 179"));
  EXPECT_EQ(finding(corrected, "misfit")["count"], 16);
  EXPECT_EQ(finding(dlr, "unassociated")["count"], 436);

  EXPECT_TRUE(finding(checked({data_file("dlr-200-local-maps").string()}, 1), "too_certain").is_object());
  const json csail = checked({data_file("pose-graphs-2d/CSAIL.g2o.gz").string()}, 1);
  EXPECT_EQ(finding(csail, "copies")["count"], 1);
  const json klinik = checked({data_file("pose-graphs-2d/ais2klinik.g2o.gz").string()}, 1);
  EXPECT_EQ(finding(klinik, "breaks")["count"], 1);
}

}  // namespace
}  // namespace mapjoin::testing
