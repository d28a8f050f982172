// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <set>
#include <string>
#include <tests/support/dimensions.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

template <typename D>
class ManhattanTest : public ::testing::Test {};
TYPED_TEST_SUITE(ManhattanTest, testing::Dimensions);

/// The number of standard deviations from chi2 to its expected value over `rows` rows.
double deviation(double chi2, std::size_t rows) {
  return (chi2 - static_cast<double>(rows)) / std::sqrt(2.0 * static_cast<double>(rows));
}

TYPED_TEST(ManhattanTest, Chi2AtTheTruthIsWhatTheStatedNoisePromises) {
  constexpr int kDim = TypeParam::value;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const auto [log, truth] = simulate_manhattan<kDim>({.poses = 2000, .seed = seed});
    const Chi2 chi2 = log_chi2(log, {truth.poses, truth.features});
    EXPECT_LT(std::abs(deviation(chi2.odometry, log.odometry().size() * kPoseDof<kDim>)), 4.0);
    EXPECT_LT(std::abs(deviation(chi2.observations, log.observations().size() * kDim)), 4.0);
    EXPECT_EQ(chi2.closures + chi2.priors, 0.0);
  }
}

TYPED_TEST(ManhattanTest, TheNoiseMultiplierScalesTheErrorsAndNotTheirWeights) {
  constexpr int kDim = TypeParam::value;
  const auto chi2 = [](double multiplier) {
    const auto [log, truth] = simulate_manhattan<kDim>({.poses = 500, .noise_multiplier = multiplier});
    return log_chi2(log, {truth.poses, truth.features}).total();
  };
  EXPECT_LT(chi2(0.0), 1e-18);
  EXPECT_NEAR(chi2(2.0), 4.0 * chi2(1.0), 1e-9 * chi2(2.0));
}

TYPED_TEST(ManhattanTest, TheSameSeedGivesTheSameLogAndAnotherSeedAnother) {
  constexpr int kDim = TypeParam::value;
  const auto measured = [](std::uint64_t seed) {
    const auto simulation = simulate_manhattan<kDim>({.poses = 300, .seed = seed});
    std::vector<double> numbers;
    for (const auto& edge : simulation.log.odometry()) {
      const auto step = local(Pose<kDim>{}, edge.measured);
      numbers.insert(numbers.end(), step.begin(), step.end());
    }
    for (const auto& o : simulation.log.observations()) numbers.insert(numbers.end(), o.measured.begin(), o.measured.end());
    return numbers;
  };
  EXPECT_EQ(measured(5), measured(5));
  EXPECT_NE(measured(5), measured(6));
}

/// The lines of a log as a g2o file, without comments, each once.
template <int Dim>
std::set<std::string> lines_of(const Log<Dim>& log) {
  const testing::TemporaryFolder folder;
  EXPECT_TRUE(write_g2o(log, folder.path() / "log.g2o"));
  std::ifstream file(folder.path() / "log.g2o");
  std::set<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with('#')) lines.insert(line);
  }
  return lines;
}

TYPED_TEST(ManhattanTest, ItsPartsHaveTheLinesOfTheWhole) {
  constexpr int kDim = TypeParam::value;
  ManhattanOptions options{.poses = 101, .chance = 0.7};
  const auto [whole, truth] = simulate_manhattan<kDim>(options);
  options.parts = 3;
  std::set<std::string> lines;
  std::size_t observations = 0;
  std::size_t edges = 0;
  for (options.part = 1; options.part <= options.parts; ++options.part) {
    const auto [log, true_part] = simulate_manhattan<kDim>(options);
    lines.merge(lines_of(log));
    observations += log.observations().size();
    edges += log.odometry().size();
    EXPECT_LE(log.poses.size(), 35U);
    const PoseIndex last(log.poses.size() - 1);
    EXPECT_EQ(true_part.poses[last].translation, truth.poses[PoseIndex(log.poses[last].key)].translation);
  }
  EXPECT_EQ(lines, lines_of(whole));
  EXPECT_EQ(observations, whole.observations().size());
  EXPECT_EQ(edges, whole.odometry().size());
}

TYPED_TEST(ManhattanTest, TheWalkStaysInItsSquareOnStreetsAndTurnsAtCornersOnly) {
  constexpr int kDim = TypeParam::value;
  const auto [log, truth] = simulate_manhattan<kDim>({.poses = 3000, .side = 20.0, .storeys = 2, .noise_multiplier = 0.0});
  std::set<int> turns_by_kind;
  for (const PoseIndex i : indices(truth.poses)) {
    const Point<kDim>& p = truth.poses[i].translation;
    const auto off_streets = (p.array() / 5.0 - (p.array() / 5.0).round() != 0.0).count();
    EXPECT_LE(off_streets, 1) << p.transpose();
    EXPECT_LE(p.template head<2>().cwiseAbs().maxCoeff(), 10.0);
    EXPECT_TRUE(kDim == 2 || (p[kDim - 1] >= 0.0 && p[kDim - 1] <= 5.0)) << p.transpose();
    if (i == 0) continue;
    const Pose<kDim> step = between(truth.poses[i - 1], truth.poses[i]);
    EXPECT_LT((step.translation - Point<kDim>::UnitX()).norm(), 1e-12);
    const auto angle = step.rotation.log();
    EXPECT_TRUE(off_streets == 0 || angle.norm() < 1e-12) << p.transpose();
    const auto quarters = (angle * 2.0 / std::numbers::pi).array().round();
    EXPECT_LE(quarters.abs().sum(), 1.0);
    turns_by_kind.insert(
        static_cast<int>((quarters * Eigen::Array<double, kRotationDof<kDim>, 1>::LinSpaced(1.0, kDim)).sum()));
  }
  // Straight on, left and right (yaw, ±kDim); in space up and down, too (pitch, ±2). Roll would be ±1.
  EXPECT_EQ(turns_by_kind, (kDim == 2 ? std::set{-2, 0, 2} : std::set{-3, -2, 0, 2, 3}));
}

TEST(ManhattanTest, ASideOfWholeBlocksHasThemAll) {
  for (const double side : {0.2, 0.3, 0.6, 0.7}) {  // 0.3 / 0.1 is less than 3
    const auto truth = simulate_manhattan<2>({.poses = 5000, .step = 0.1, .block = 0.1, .side = side, .range = 0.0}).truth;
    Eigen::AlignedBox2d walked;
    for (const auto& pose : truth.poses) walked.extend(pose.translation);
    EXPECT_NEAR(walked.sizes().x(), side, 1e-9);
    EXPECT_NEAR(walked.sizes().y(), side, 1e-9);
  }
}

TEST(ManhattanTest, GoesStraightOnAtHalfOfTheOpenCorners) {
  const auto truth = simulate_manhattan<2>({.poses = 50'000, .side = 500.0}).truth;
  double corners = 0.0;
  double left = 0.0;
  double right = 0.0;
  for (PoseIndex i = 1; i < indices(truth.poses).last; ++i) {
    const Point<2>& p = truth.poses[i].translation;
    if (std::remainder(p.x(), 5.0) != 0.0 || std::remainder(p.y(), 5.0) != 0.0) continue;
    if (p.cwiseAbs().maxCoeff() >= 250.0) continue;
    const double turn = between(truth.poses[i - 1], truth.poses[i]).rotation.log()[0];
    corners += 1.0;
    left += turn > 1.0 ? 1.0 : 0.0;
    right += turn < -1.0 ? 1.0 : 0.0;
  }
  const double four_sigma = 4.0 * std::sqrt(0.25 * 0.75 * corners);
  EXPECT_GT(corners, 5000.0);
  EXPECT_NEAR(left, 0.25 * corners, four_sigma);
  EXPECT_NEAR(right, 0.25 * corners, four_sigma);
}

TYPED_TEST(ManhattanTest, SeesEveryFeatureInRangeAndNoOther) {
  constexpr int kDim = TypeParam::value;
  const auto [log, truth] = simulate_manhattan<kDim>({.poses = 400, .noise_multiplier = 0.0});
  std::set<std::pair<PoseIndex, FeatureIndex>> seen;
  for (const auto& o : log.observations()) seen.emplace(o.base, o.target);
  EXPECT_EQ(seen.size(), log.observations().size());
  for (const auto& [pose, feature] : seen) EXPECT_LE((truth.features[feature] - truth.poses[pose].translation).norm(), 3.0);
  std::size_t in_range = 0;
  for (const PoseIndex i : indices(truth.poses)) {
    for (const Point<kDim>& feature : truth.features) {
      in_range += (feature - truth.poses[i].translation).norm() <= 3.0 ? 1 : 0;
    }
  }
  EXPECT_EQ(in_range, seen.size());
  // With one feature in each cell, a ball of radius 3 m holds its volume over that of a cell on average.
  const double expected = (kDim == 2 ? 9.0 / 4.0 : 36.0 / 8.0) * std::numbers::pi;
  EXPECT_NEAR(static_cast<double>(in_range) / 400.0, expected, 0.1 * expected);
}

TYPED_TEST(ManhattanTest, FeaturesKeepToTheirCells) {
  constexpr int kDim = TypeParam::value;
  const auto truth = simulate_manhattan<kDim>({.poses = 400}).truth;
  std::set<std::vector<double>> cells;
  double largest = 0.0;
  for (const Point<kDim>& feature : truth.features) {
    const Eigen::Array<double, kDim, 1> cell = (feature.array() / 2.0).floor();
    cells.insert({cell.begin(), cell.end()});
    largest = std::max(largest, (feature.array() - 2.0 * cell - 1.0).abs().maxCoeff());
  }
  EXPECT_EQ(cells.size(), truth.features.size());
  EXPECT_LE(largest, 0.3);
  EXPECT_GT(largest, 0.28);
}

TYPED_TEST(ManhattanTest, TheChanceOfSeeingThinsTheObservationsAndLeavesThePathAlone) {
  constexpr int kDim = TypeParam::value;
  const auto all = simulate_manhattan<kDim>({.poses = 1000});
  const auto some = simulate_manhattan<kDim>({.poses = 1000, .chance = 0.3});
  const auto n = static_cast<double>(all.log.observations().size());
  EXPECT_NEAR(static_cast<double>(some.log.observations().size()), 0.3 * n, 4.0 * std::sqrt(0.21 * n));
  EXPECT_TRUE(all.log.odometry().back().measured.translation == some.log.odometry().back().measured.translation);
}

TYPED_TEST(ManhattanTest, TheLogKeepsThePromisesOfLog) {
  constexpr int kDim = TypeParam::value;
  const auto [log, truth] = simulate_manhattan<kDim>({.poses = 250});
  EXPECT_EQ(log.poses.size(), 250u);
  EXPECT_EQ(log.odometry().size(), 249u);
  EXPECT_TRUE(std::is_sorted(log.features.begin(), log.features.end()));
  EXPECT_TRUE(std::is_sorted(log.graph.feature_factors.begin(), log.graph.feature_factors.end(),
                             [](const auto& a, const auto& b) { return a.base < b.base; }));
  EXPECT_EQ(truth.poses.size(), log.poses.size());
  EXPECT_EQ(truth.features.size(), log.features.size());
  const std::size_t rows = log.odometry().size() * kPoseDof<kDim> + log.observations().size() * kDim;
  EXPECT_EQ(degrees_of_freedom(log, truth.gauge.size()),
            static_cast<std::int64_t>(rows - 249 * kPoseDof<kDim> - log.features.size() * kDim));
}

TEST(ManhattanTest, ThePlaneIsTheSameBitsOnEveryMachine) {
  const auto log = simulate_manhattan<2>({.poses = 100, .seed = 42}).log;
  const Pose<2>& last = log.odometry().back().measured;
  EXPECT_EQ(last.translation.x(), 0x1.00d91296614a6p+0);
  EXPECT_EQ(last.rotation.angle(), 0x1.f67b6d46e257ep-7);
  EXPECT_EQ(log.graph.feature_factors.back().measured.y(), 0x1.02c4ede75a529p+0);
}

TEST(ManhattanTest, OnePoseIsALogToo) {
  const auto log = simulate_manhattan<2>({.poses = 1}).log;
  EXPECT_EQ(log.poses.size(), 1u);
  EXPECT_TRUE(log.odometry().empty());
  EXPECT_FALSE(log.observations().empty());
}

TEST(ManhattanTest, EveryViolationIsNamed) {
  const ManhattanOptions options{.poses = 0, .step = 0.7, .feature_jitter = 1.5, .chance = -0.1, .turn_noise = 0.0};
  EXPECT_THAT(options.validate(), ::testing::ElementsAre(::testing::HasSubstr("poses"), ::testing::HasSubstr("block"),
                                                         ::testing::HasSubstr("jitter"), ::testing::HasSubstr("chance"),
                                                         ::testing::HasSubstr("turn noise")));
  EXPECT_THROW(simulate_manhattan<2>(options), std::invalid_argument);
  EXPECT_THAT(ManhattanOptions{.range = std::nan("")}.validate(), ::testing::ElementsAre(::testing::HasSubstr("range")));
  EXPECT_THAT((ManhattanOptions{.poses = 2, .part = 3, .parts = 3}.validate()),
              ::testing::ElementsAre(::testing::HasSubstr("part must be")));
  EXPECT_THAT(ManhattanOptions{}.validate(), ::testing::IsEmpty());
}

TEST(Manhattan, EndsWithAWholeLogOnceAStopIsRequested) {
  std::stop_source source;
  source.request_stop();
  const auto [log, truth] = simulate_manhattan<2>({.poses = ManhattanOptions::kMostPoses}, source.get_token());
  EXPECT_EQ(log.poses.size(), 1u);
  EXPECT_EQ(log.sessions.at(0).end, PoseIndex(1));
  EXPECT_EQ(truth.poses.size(), 1u);
}

}  // namespace
}  // namespace mapjoin
