// SPDX-License-Identifier: BSD-3-Clause
// The public data sets, joined and polished, against what is known of their optima.
#include <gtest/gtest.h>

#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/data.hpp>

namespace mapjoin {
namespace {

using testing::data_file;

template <int Dim>
Log<Dim> log_in(const std::string& file, const ReadOptions& options = {}) {
  auto log = open_log(data_file(file), options);
  if (!log) throw std::runtime_error(log.error().message);
  return std::get<Log<Dim>>(*std::move(log));
}

RunOptions maps_of(double poses) {
  RunOptions options;
  options.split = {SplitRule::kPoses, poses};
  return options;
}

template <int Dim>
RunResult<Dim> converged(Expected<RunResult<Dim>> result) {
  if (!result) throw std::runtime_error(result.error().message);
  EXPECT_TRUE(result->converged());
  return *std::move(result);
}

struct Optimum {
  std::string file;
  double chi2;
  double tolerance;
  Covariance covariance = Covariance::kOriginal;
  PoseError pose_error = PoseError::kPaper;
};

void PrintTo(const Optimum& optimum, std::ostream* out) {
  *out << optimum.file << ", chi2 " << optimum.chi2;
}

class LogOptimum : public ::testing::TestWithParam<Optimum> {};

TEST_P(LogOptimum, IsReached) {
  auto log = log_in<2>(GetParam().file, {.pose_error = GetParam().pose_error});
  if (GetParam().covariance == Covariance::kIdentity) use_identity_covariance(log);
  const auto result = converged(run(log, RunOptions{}));
  EXPECT_NEAR(result.chi2, GetParam().chi2, GetParam().tolerance);
}

constexpr auto kIdentity = Covariance::kIdentity;
constexpr auto kOriginal = Covariance::kOriginal;
INSTANTIATE_TEST_SUITE_P(Data, LogOptimum,
                         ::testing::Values(Optimum{"vicpark-6898/VicPark_clean_data.mat", 9012.7193, 1e-3},
                                           Optimum{"vicpark-6898/vicpark_clean_data.txt.gz", 9012.7193, 1e-3},
                                           Optimum{"vicpark-6898/vicpark6898.g2o.gz", 9012.7193, 1e-3},
                                           Optimum{"vicpark-6898/VicPark_clean_data.mat", 1283.1504, 1e-3, kIdentity},
                                           Optimum{"dlr/corrected_data_circles.mat", 27688.5556, 1e-3},
                                           Optimum{"dlr/dlr_corrected.txt.gz", 27688.5556, 1e-3},
                                           Optimum{"dlr/dlr_corrected.g2o.gz", 27688.5556, 1e-3},
                                           Optimum{"dlr/corrected_data_circles.mat", 20.2524, 1e-4, kIdentity},
                                           Optimum{"dlr/dlr.g2o.gz", 56871.449, 1e-2},
                                           Optimum{"dlr/dlr.g2o.gz", 56860.353, 1e-2, kOriginal, PoseError::kG2o},
                                           Optimum{"citytrees10000/cityTrees10000.txt", 8668.929, 1e-2},
                                           Optimum{"citytrees10000/montecarlo/cityTrees10000_0.txt.gz", 8637.85, 1e-2},
                                           Optimum{"citytrees10000/montecarlo/cityTrees10000_1.txt.gz", 8878.50, 1e-2},
                                           Optimum{"citytrees10000/montecarlo/cityTrees10000_2.txt.gz", 8729.20, 1e-2},
                                           Optimum{"citytrees10000/montecarlo/cityTrees10000_3.txt.gz", 8823.15, 1e-2},
                                           Optimum{"citytrees10000/montecarlo/cityTrees10000_4.txt.gz", 8745.87, 1e-2}));

TEST(JoinedDataTest, VictoriaParkIsSolvedAlongTheTreeWithoutLocalMaps) {
  RunOptions options;
  options.schedule = Schedule::kTree;
  const auto result = converged(solve(log_in<2>("vicpark-6898/VicPark_clean_data.mat"), options));
  EXPECT_NEAR(result.chi2, 9012.7193, 1e-3);
}

struct Landmarks {
  std::string file;
  double chi2;
};

void PrintTo(const Landmarks& landmarks, std::ostream* out) {
  *out << landmarks.file;
}

class MapLength : public ::testing::TestWithParam<Landmarks> {};

TEST_P(MapLength, DoesNotChangeTheOptimumAndHardlyTheJoinedMap) {
  const auto log = log_in<2>(GetParam().file);
  for (const double poses : {1.0, 5.0, 10.0, 16.0, 35.0, 60.0, 100.0}) {
    SCOPED_TRACE(poses);
    const auto result = converged(run(log, maps_of(poses)));
    EXPECT_NEAR(result.chi2, GetParam().chi2, 1e-3);
    const double most = poses == 1.0 ? 1.0 + 1e-6 : poses <= 60.0 ? 1.001 : 1.01;
    EXPECT_LE(*result.recovered_chi2, most * result.chi2);
  }
}
INSTANTIATE_TEST_SUITE_P(Data, MapLength,
                         ::testing::Values(Landmarks{"vicpark-6898/VicPark_clean_data.mat", 9012.7193},
                                           Landmarks{"dlr/corrected_data_circles.mat", 27688.5556}));

class SubmapSetOptimum : public ::testing::TestWithParam<Optimum> {};

TEST_P(SubmapSetOptimum, IsReached) {
  const auto set = read_local_map_set(data_file(GetParam().file));
  ASSERT_TRUE(set) << set.error().message;
  const auto result = converged(run(std::get<SubmapSet<2>>(*set), RunOptions{}));
  EXPECT_NEAR(result.chi2, GetParam().chi2, GetParam().tolerance);
}
INSTANTIATE_TEST_SUITE_P(
    Data, SubmapSetOptimum,
    ::testing::Values(Optimum{"vicpark-200-local-maps", 3643.43494, 1e-4}, Optimum{"dlr-200-local-maps", 11163.6434, 1e-3},
                      Optimum{"sim-35188/localmaps_mat.tar.gz", 10315.6331, 1e-3},
                      Optimum{"sim-35188/localmaps_txt.tar.gz", 10315.6331, 1e-3}, Optimum{"sim-535/local_maps", 7.832, 1e-3},
                      Optimum{"small-local-maps-5-truth", 21.068, 1e-3}, Optimum{"small-local-maps-64", 4975.918, 1e-2}));

/// Expects Ceres to agree on chi2 and, started from the result, to gain less than a millionth of it.
template <int Dim, typename Input>
void expect_ceres_gains_nothing(const Input& input, const RunResult<Dim>& result) {
  const Values<Dim> state{result.map.poses, result.map.features};
  const auto ceres = testing::ceres_optimum(input, state, {.max_iterations = 20, .function_tolerance = 1e-8});
  EXPECT_NEAR(ceres.initial_chi2, result.chi2, 1e-9 * result.chi2);
  EXPECT_GT(ceres.chi2, (1.0 - 1e-6) * result.chi2) << ceres.summary;
}

class PoseGraph : public ::testing::TestWithParam<std::string> {};

TEST_P(PoseGraph, LeavesCeresNothingToGain) {
  const auto any = open_log(data_file(GetParam()), {.repair_information = true});
  ASSERT_TRUE(any) << any.error().message;
  std::visit([](const auto& log) { expect_ceres_gains_nothing(log, converged(run(log, RunOptions{}))); }, *any);
}
INSTANTIATE_TEST_SUITE_P(Data, PoseGraph,
                         ::testing::Values("pose-graphs-2d/MIT.g2o.gz", "pose-graphs-2d/manhattan.g2o.gz",
                                           "pose-graphs-2d/city10000.g2o.gz", "pose-graphs-3d/sphere2500.g2o.gz",
                                           "pose-graphs-3d/torus3D.g2o.gz", "pose-graphs-3d/cubicle.g2o.gz",
                                           "torus2000points/torus2000Points.txt"));

TEST(JoinedDataTest, TheMapsOfTheSimulationInSpaceLeaveCeresNothingToGain) {
  for (const std::string kind : {"mat", "txt"}) {
    const auto set = read_local_map_set(data_file("sim3d-870-local-maps/localmaps_" + kind + ".tar.gz"));
    ASSERT_TRUE(set) << set.error().message;
    const auto& maps = std::get<SubmapSet<3>>(*set);
    expect_ceres_gains_nothing(maps, converged(run(maps, RunOptions{})));
  }
}

TEST(ComparisonData, JoiningAtOnceReachesTheOptimumOfVictoriaParkAndFullSlamDoesNot) {
  const auto log = log_in<2>("vicpark-6898/vicpark6898.g2o.gz");
  ComparisonOptions<2> options;
  for (const int steps : {1, 20, 60}) {
    for (const JoinedState state : {JoinedState::kAbsolute, JoinedState::kRelative}) {
      options.cases.push_back({steps, state, Schedule::kBatch, false});
    }
  }
  const auto comparison = compare(log, options);
  ASSERT_TRUE(comparison) << comparison.error().message;
  for (const CaseFigures& figures : comparison->cases) {
    SCOPED_TRACE(to_string(figures.way));
    EXPECT_EQ(figures.reaches_best, !figures.way.is_full_slam());
    if (figures.reaches_best) {
      EXPECT_NEAR(figures.polished.chi2, 9012.7193, 1e-3);
      EXPECT_LT(figures.joined.from_best.poses.translation.max, 0.1);
    } else {
      EXPECT_GT(figures.polished.chi2, 1e6);
    }
  }
}

}  // namespace
}  // namespace mapjoin
