// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/study/basin.hpp>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/data.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using ::testing::SizeIs;

template <typename D>
class BasinTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  BasinTest() : world_(testing::small_world<kDim>({.poses = 40})) {
    options_.splits = {{SplitRule::kPoses, 5.0}, {SplitRule::kPoses, 10.0}};
    options_.seeds = 3;
  }

  testing::SmallWorld<kDim> world_;
  BasinOptions options_;
};
TYPED_TEST_SUITE(BasinTest, testing::Dimensions);

/// The cells for which `f` is true.
template <typename F>
std::vector<BasinCell> cells_where(const Basin& basin, F&& f) {
  std::vector<BasinCell> chosen;
  std::copy_if(basin.cells.begin(), basin.cells.end(), std::back_inserter(chosen), f);
  return chosen;
}

TYPED_TEST(BasinTest, HasACellForEveryCovarianceFormulationSplitMethodAndStart) {
  const auto found = basin(this->world_.log, this->options_).value();
  EXPECT_THAT(found.covariances, SizeIs(2));
  EXPECT_THAT(found.cells, SizeIs(2 * (2 + 2 * 2) * 2 * 3));
  for (const BasinCell& cell : found.cells) EXPECT_THAT(cell.runs, SizeIs(cell.start == Start::kRandom ? 3 : 1));
}

TYPED_TEST(BasinTest, KnowsTheOptimumThatCeresFindsFromTheTruth) {
  const auto found = basin(this->world_.log, this->options_).value();
  auto log = this->world_.log;
  EXPECT_NEAR(found.best_chi2[0], testing::ceres_optimum(log, this->world_.truth).chi2, 1e-6 * found.best_chi2[0]);
  use_identity_covariance(log);
  EXPECT_NEAR(found.best_chi2[1], testing::ceres_optimum(log, this->world_.truth).chi2, 1e-6 * found.best_chi2[1]);
}

TYPED_TEST(BasinTest, ReachesItFromEverywhereWhereItIsGradual) {
  const auto found = basin(this->world_.log, this->options_).value();
  const auto gradual = cells_where(found, [](const BasinCell& cell) {
    return cell.formulation.state == JoinedState::kRelative && cell.method == BasinMethod::kDefault;
  });
  ASSERT_THAT(gradual, SizeIs(2 * 3 * 3));
  for (const BasinCell& cell : gradual) EXPECT_EQ(cell.hits(), cell.runs.size()) << to_string(cell.start);
}

TYPED_TEST(BasinTest, SaysWhereASolveEndsThatMayNotGoOn) {
  this->options_.max_iterations = 1;
  const auto found = basin(this->world_.log, this->options_).value();
  const auto cut_off = cells_where(found, [](const BasinCell& cell) {
    return !cell.formulation.is_joining && cell.method == BasinMethod::kGaussNewton && cell.start == Start::kRandom;
  });
  ASSERT_FALSE(cut_off.empty());
  for (const BasinCell& cell : cut_off) {
    EXPECT_EQ(cell.hits(), 0U);
    for (const BasinRun& run : cell.runs) {
      EXPECT_EQ(run.status, MinimiseStatus::kMaxIterations);
      EXPECT_GT(run.chi2, 2.0 * found.best_chi2[cell.covariance == Covariance::kOriginal ? 0 : 1]);
    }
  }
}

TYPED_TEST(BasinTest, TakesASplitThatWasMadeBefore) {
  const auto& log = this->world_.log;
  const auto found = basin(log, split(log, this->options_.splits.front()), this->options_).value();
  EXPECT_THAT(found.cells, SizeIs(2 * (2 + 2) * 2 * 3));
}

TYPED_TEST(BasinTest, JoinsASetOfLocalMaps) {
  const auto set = testing::small_submap_set(this->world_.log, 5.0);
  const auto done = basin(set, this->options_);
  ASSERT_TRUE(done) << done.error().message;
  const Basin& found = *done;
  EXPECT_THAT(found.cells, SizeIs(2 * 2 * 2 * 3));
  EXPECT_NEAR(found.best_chi2[0], run(set, RunOptions{}).value().chi2, 1e-6 * found.best_chi2[0]);
  for (const BasinCell& cell : found.cells) {
    EXPECT_TRUE(cell.formulation.is_joining);
    EXPECT_EQ(cell.maps, set.graph.submaps.size());
    EXPECT_TRUE(cell.start != Start::kComposed || cell.hits() == 1) << to_string(cell.method);
  }
}

TYPED_TEST(BasinTest, SaysWhyThereIsNoMapAtAll) {
  auto log = this->world_.log;
  for (auto& edge : log.graph.pose_factors) edge.information.setZero();
  log.graph.pose_factors.resize(log.odometry().size());
  log.graph.feature_factors.clear();
  const auto found = basin(log, this->options_);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, ErrorKind::kBadInput);
}

TYPED_TEST(BasinTest, RefusesAnExperimentWithoutSeedsOrSplits) {
  this->options_.seeds = 0;
  this->options_.splits.clear();
  EXPECT_THAT(this->options_.validate(), SizeIs(2));
  EXPECT_THROW(basin(this->world_.log, this->options_), std::invalid_argument);
}

TYPED_TEST(BasinTest, StopsWhenAskedTo) {
  std::stop_source source;
  this->options_.progress = [&](std::size_t, std::size_t) { source.request_stop(); };
  const auto found = basin(this->world_.log, this->options_, source.get_token());
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, ErrorKind::kInterrupted);
}

}  // namespace
}  // namespace mapjoin
