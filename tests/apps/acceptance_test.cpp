// SPDX-License-Identifier: BSD-3-Clause
// The least chi2 on the public data sets, known from other programs, which the command must reach.
#include <gtest/gtest.h>

#include <cmath>
#include <tests/apps/command.hpp>
#include <tests/support/data.hpp>

namespace mapjoin::testing {
namespace {

using nlohmann::json;

struct Case {
  std::string name;
  std::string input;
  std::string command;
  std::vector<std::string> options;
  double chi2;
  double tolerance;
};

class Acceptance : public ::testing::TestWithParam<Case> {};

TEST_P(Acceptance, ReachesTheLeastChi2) {
  const Case& want = GetParam();
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {want.command, data_file(want.input).string()};
  arguments.insert(arguments.end(), want.options.begin(), want.options.end());
  if (want.command != "run") arguments.insert(arguments.end(), {"-o", (folder.path() / "map.g2o").string()});
  const json report = report_of(arguments);
  EXPECT_EQ(report.at("converged"), true);
  EXPECT_NEAR(report.at("chi2"), want.chi2, want.tolerance);
}

const std::vector<std::string> kIdentity = {"--covariance", "identity"};
const std::vector<std::string> kG2oError = {"--g2o-error", "g2o"};

INSTANTIATE_TEST_SUITE_P(
    VictoriaPark, Acceptance,
    ::testing::Values(Case{"g2o", "vicpark-6898/vicpark6898.g2o.gz", "run", {}, 9012.7193, 1e-3},
                      Case{"mat", "vicpark-6898/VicPark_clean_data.mat", "run", {}, 9012.7193, 1e-3},
                      Case{"text", "vicpark-6898/vicpark_clean_data.txt.gz", "run", {}, 9012.7193, 1e-3},
                      Case{"identity", "vicpark-6898/VicPark_clean_data.mat", "run", kIdentity, 1283.1504, 1e-3},
                      Case{"solve_tree", "vicpark-6898/vicpark6898.g2o.gz", "solve", {"--schedule", "tree"}, 9012.7193, 1e-3},
                      Case{"200_maps", "vicpark-200-local-maps", "join", {}, 3643.43494, 1e-4}),
    [](const auto& info) { return info.param.name; });

INSTANTIATE_TEST_SUITE_P(Dlr, Acceptance,
                         ::testing::Values(Case{"mat", "dlr/corrected_data_circles.mat", "run", {}, 27688.5556, 1e-3},
                                           Case{"text", "dlr/dlr_corrected.txt.gz", "run", {}, 27688.5556, 1e-3},
                                           Case{"g2o", "dlr/dlr_corrected.g2o.gz", "run", {}, 27688.5556, 1e-3},
                                           Case{"identity", "dlr/corrected_data_circles.mat", "run", kIdentity, 20.2524, 1e-4},
                                           Case{"original_association", "dlr/dlr.g2o.gz", "run", {}, 56871.449, 1e-2},
                                           Case{"original_association_g2o_error", "dlr/dlr.g2o.gz", "run", kG2oError, 56860.353,
                                                1e-2},
                                           Case{"200_maps", "dlr-200-local-maps", "join", {}, 11163.6434, 1e-3}),
                         [](const auto& info) { return info.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Simulated, Acceptance,
    ::testing::Values(Case{"sim35188_mat", "sim-35188/localmaps_mat.tar.gz", "join", {}, 10315.6331, 1e-3},
                      Case{"sim35188_text", "sim-35188/localmaps_txt.tar.gz", "join", {}, 10315.6331, 1e-3},
                      Case{"sim535", "sim-535/local_maps", "join", {}, 7.832, 1e-3},
                      Case{"citytrees", "citytrees10000/cityTrees10000.txt", "run", {}, 8668.929, 1e-2},
                      Case{"citytrees_0", "citytrees10000/montecarlo/cityTrees10000_0.txt.gz", "run", {}, 8637.85, 1e-2},
                      Case{"citytrees_1", "citytrees10000/montecarlo/cityTrees10000_1.txt.gz", "run", {}, 8878.50, 1e-2},
                      Case{"citytrees_2", "citytrees10000/montecarlo/cityTrees10000_2.txt.gz", "run", {}, 8729.20, 1e-2},
                      Case{"citytrees_3", "citytrees10000/montecarlo/cityTrees10000_3.txt.gz", "run", {}, 8823.15, 1e-2},
                      Case{"citytrees_4", "citytrees10000/montecarlo/cityTrees10000_4.txt.gz", "run", {}, 8745.87, 1e-2}),
    [](const auto& info) { return info.param.name; });

/// A log of the paper and its optimum.
struct PaperLog {
  std::string name;
  std::string input;
  double chi2;
};

class JoiningItself : public ::testing::TestWithParam<PaperLog> {};

TEST_P(JoiningItself, OfOneStepMapsIsFullSlam) {
  const json report = report_of({"run", data_file(GetParam().input).string(), "--poses-per-map", "1", "--no-polish"});
  EXPECT_NEAR(report.at("recover").at("chi2"), GetParam().chi2, 1e-6 * GetParam().chi2);
}

TEST_P(JoiningItself, ComesWithinAThousandthOfTheOptimumBeforePolishing) {
  for (const std::string poses : {"5", "10", "16", "35", "60"}) {
    const json report = report_of({"run", data_file(GetParam().input).string(), "--poses-per-map", poses});
    EXPECT_LE(report.at("recover").at("chi2"), 1.001 * GetParam().chi2) << poses << " poses per map";
  }
}

TEST_P(JoiningItself, LeadsToTheSameOptimumForMapsOfAnyLength) {
  for (const std::string poses : {"1", "5", "10", "20", "35", "60", "100"}) {
    const json report = report_of({"run", data_file(GetParam().input).string(), "--poses-per-map", poses});
    EXPECT_NEAR(report.at("chi2"), GetParam().chi2, 1e-3) << poses << " poses per map";
  }
}

INSTANTIATE_TEST_SUITE_P(OnThePapersLogs, JoiningItself,
                         ::testing::Values(PaperLog{"vicpark", "vicpark-6898/VicPark_clean_data.mat", 9012.719280},
                                           PaperLog{"dlr", "dlr/corrected_data_circles.mat", 27688.555566}),
                         [](const auto& info) { return info.param.name; });

/// Logs whose optimum is checked against Ceres in tests/join; here the command must converge.
class PublicLog : public ::testing::TestWithParam<Case> {};

TEST_P(PublicLog, IsMapped) {
  std::vector<std::string> arguments = {GetParam().command, data_file(GetParam().input).string()};
  arguments.insert(arguments.end(), GetParam().options.begin(), GetParam().options.end());
  EXPECT_EQ(report_of(arguments).at("converged"), true);
}

INSTANTIATE_TEST_SUITE_P(
    PoseGraphs, PublicLog,
    ::testing::Values(Case{"mit", "pose-graphs-2d/MIT.g2o.gz", "run", {}, 0, 0},
                      Case{"manhattan", "pose-graphs-2d/manhattan.g2o.gz", "run", {}, 0, 0},
                      Case{"city10000", "pose-graphs-2d/city10000.g2o.gz", "run", {}, 0, 0},
                      Case{"sphere2500", "pose-graphs-3d/sphere2500.g2o.gz", "run", {}, 0, 0},
                      Case{"torus3d", "pose-graphs-3d/torus3D.g2o.gz", "run", {}, 0, 0},
                      Case{"torus2000points", "torus2000points/torus2000Points.txt", "run", {}, 0, 0},
                      Case{"cubicle", "pose-graphs-3d/cubicle.g2o.gz", "run", {"--repair-information"}, 0, 0}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace mapjoin::testing
