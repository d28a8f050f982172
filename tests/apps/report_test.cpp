// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

using nlohmann::json;

/// The keys of a report that other programs rely on, as JSON pointers.
const std::vector<std::string> kPromised = {"/schema_version",
                                            "/version",
                                            "/command",
                                            "/input",
                                            "/dimension",
                                            "/convention/pose_error",
                                            "/convention/rotation_information",
                                            "/convention/covariance",
                                            "/units/length",
                                            "/units/angle",
                                            "/sessions",
                                            "/poses",
                                            "/features",
                                            "/odometry",
                                            "/closures",
                                            "/observations",
                                            "/priors",
                                            "/fixed_poses",
                                            "/stamps",
                                            "/repeated_edges",
                                            "/symmetrised_matrices",
                                            "/largest_asymmetry",
                                            "/repaired_informations",
                                            "/missing_informations",
                                            "/unassociated",
                                            "/skipped",
                                            "/gps",
                                            "/local_maps/count",
                                            "/local_maps/spans",
                                            "/local_maps/poses_per_map",
                                            "/local_maps/iterations",
                                            "/local_maps/seconds",
                                            "/join/status",
                                            "/join/state",
                                            "/join/start",
                                            "/join/schedule",
                                            "/join/confirmed",
                                            "/join/method",
                                            "/join/engine",
                                            "/join/iterations",
                                            "/join/factorisations",
                                            "/join/turned",
                                            "/join/chi2",
                                            "/join/dof",
                                            "/join/maps",
                                            "/join/course",
                                            "/join/seconds",
                                            "/recover/chi2",
                                            "/recover/unrecovered",
                                            "/polish/status",
                                            "/polish/iterations",
                                            "/polish/chi2",
                                            "/converged",
                                            "/chi2",
                                            "/dof",
                                            "/gauge/held_poses",
                                            "/certainty/estimate",
                                            "/certainty/nees/poses/value",
                                            "/certainty/nees/poses/dimensions",
                                            "/certainty/nees/poses/least",
                                            "/certainty/nees/poses/most",
                                            "/certainty/nees/poses/probability",
                                            "/certainty/nees/features/value",
                                            "/certainty/nees/features/dimensions",
                                            "/certainty/nees/features/least",
                                            "/certainty/nees/features/most",
                                            "/certainty/nees/features/probability",
                                            "/certainty/nees/joint/value",
                                            "/certainty/nees/joint/dimensions",
                                            "/certainty/nees/joint/least",
                                            "/certainty/nees/joint/most",
                                            "/certainty/nees/joint/probability",
                                            "/files",
                                            "/seconds/read",
                                            "/seconds/build",
                                            "/seconds/join",
                                            "/seconds/recover",
                                            "/seconds/polish",
                                            "/seconds/covariances",
                                            "/seconds/write",
                                            "/seconds/total",
                                            "/peak_memory_mb",
                                            "/blas"};

/// A report without times, memory and files.
json without_figures_of_the_machine(json report) {
  for (const std::string key : {"seconds", "peak_memory_mb", "files"}) report.erase(key);
  report["local_maps"].erase("seconds");
  report["join"].erase("seconds");
  return report;
}

TEST(Report, HasEveryKeyWhateverTheCommandDoes) {
  const TemporaryFolder folder;
  const std::string store = (folder.path() / "maps").string();
  const std::string map = (folder.path() / "map.g2o").string();
  for (const auto& arguments : std::vector<std::vector<std::string>>{{"run", kBundledLog},
                                                                     {"run", kBundledLog, "--no-polish"},
                                                                     {"build", kBundledLog, "-o", store},
                                                                     {"join", store, "-o", map},
                                                                     {"solve", kBundledLog, "-o", map}}) {
    const json report = report_of(arguments);
    EXPECT_EQ(report.at("command"), arguments.front());
    for (const std::string& key : kPromised) EXPECT_TRUE(report.contains(json::json_pointer(key))) << key;
  }
}

TEST(Report, SaysWhatTheRunDid) {
  const json report = report_of({"run", kBundledLog, "--poses-per-map", "20", "--schedule", "sequential", "--method", "lm"});
  EXPECT_EQ(report.at("dimension"), 2);
  EXPECT_EQ(report.at("poses"), 1000);
  EXPECT_EQ(report.at("odometry"), 999);
  EXPECT_EQ(report.at("local_maps").at("poses_per_map"), 20);
  EXPECT_EQ(report.at("local_maps").at("count"), 50);
  EXPECT_EQ(report.at("join").at("schedule"), "sequential");
  EXPECT_EQ(report.at("join").at("method"), "lm");
  EXPECT_EQ(report.at("join").at("status"), "converged");
  EXPECT_EQ(report.at("converged"), true);
  EXPECT_EQ(report.at("convention").at("covariance"), "original");
  EXPECT_EQ(report.at("gauge").at("held_poses"), json::parse(R"([{"session": 0, "pose": 0}])"));
  EXPECT_GE(report.at("recover").at("chi2"), report.at("chi2"));
  EXPECT_NEAR(report.at("polish").at("chi2"), report.at("chi2"), 1e-6);
  // Noise as stated: chi2 is within five of its standard deviations √(2 dof) of dof.
  const double dof = report.at("dof");
  EXPECT_NEAR(report.at("chi2"), dof, 5.0 * std::sqrt(2.0 * dof));
}

TEST(Report, SaysWhetherTheWaysOfJoiningConfirmTheOptimum) {
  const TemporaryFolder folder;
  const std::string lost = (folder.path() / "lost.g2o").string();
  // Few features, and odometry twenty times as noisy as usual: each of three ways ends at another optimum.
  ASSERT_EQ(call({"simulate", "--poses", "400", "--seed", "11", "--feature-cell", "7.5", "--step-noise", "0.6", "--turn-noise",
                  "0.14", "-o", lost, "--quiet"})
                .exit_code,
            0);
  const std::vector<std::pair<std::vector<std::string>, json>> cases{
      {{"run", lost}, false}, {{"run", kBundledLog}, true}, {{"run", lost, "--schedule", "tree"}, nullptr}};
  for (const auto& [arguments, is_confirmed] : cases) {
    EXPECT_EQ(report_of(arguments).at("join").at("confirmed"), is_confirmed);
    EXPECT_EQ(count_of(call(arguments).out, "is not confirmed"), is_confirmed == json(false) ? 1U : 0U);
  }
}

TEST(Report, IsTheSameForAnyNumberOfThreads) {
  for (const std::string name : {"manhattan2d.g2o", "manhattan3d.g2o"}) {
    const std::string log = (kBundledData / name).string();
    const json one = report_of({"run", log, "--jobs", "1"});
    const json two = report_of({"run", log, "--jobs", "2"});
    EXPECT_EQ(without_figures_of_the_machine(one), without_figures_of_the_machine(two));
  }
}

TEST(Report, GoesToAFileBesideTheSummary) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "report.json").string();
  const Ended ended = call({"run", kBundledLog, "--report", path});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.out, ::testing::HasSubstr("chi2"));
  EXPECT_EQ(json::parse(content_of(path)).at("command"), "run");
}

TEST(Summary, IsLeftOutWhenAskedTo) {
  const Ended ended = call({"run", kBundledLog, "--quiet"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_EQ(ended.out, "");
  EXPECT_EQ(ended.err, "");
}

TEST(Summary, NamesGaugeAndConventionAndWhatIsSpecialInTheData) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog + "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  const Ended ended = call({"run", log.string(), "--covariance", "identity"});
  EXPECT_EQ(ended.err, "");
  EXPECT_THAT(ended.out, ::testing::HasSubstr("pose 0 anchored"));
  EXPECT_THAT(ended.out, ::testing::HasSubstr("identity covariance"));
  EXPECT_THAT(ended.out, ::testing::HasSubstr("1 edge repeats another"));
}

}  // namespace
}  // namespace mapjoin::testing
