// SPDX-License-Identifier: BSD-3-Clause
// Engines all end at the same optimum.
#include <gtest/gtest.h>

#include <mapjoin/join/run.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/every.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename Dimension>
class EngineTest : public ::testing::Test {
 protected:
  static constexpr int kDim = Dimension::value;

  static RunResult<kDim> run_by(const Log<kDim>& log, Engine engine, Schedule schedule) {
    RunOptions options;
    options.split = {SplitRule::kPoses, 6.0};
    options.schedule = schedule;
    options.solver.engine = engine;
    options.covariances = options.marginals = true;
    auto result = run(log, options);
    EXPECT_TRUE(result) << result.error().message;
    return *std::move(result);
  }
  /// The largest entry of a difference of two estimates, in standard deviations of that entry.
  static double in_deviations(const Eigen::VectorXd& difference, const Eigen::MatrixXd& covariance) {
    double most = 0.0;
    for (Eigen::Index i = 0; i < difference.size(); ++i) {
      if (difference[i] != 0.0) most = std::max(most, std::abs(difference[i]) / std::sqrt(covariance(i, i)));
    }
    return most;
  }
};
TYPED_TEST_SUITE(EngineTest, testing::Dimensions);

TYPED_TEST(EngineTest, EndsAtTheOptimumOfTheFronts) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = testing::small_world<kDim>({.poses = 120, .features = 60, .sessions = 2});
  for (const Schedule schedule : testing::every<Schedule>()) {
    const auto expected = this->run_by(world.log, Engine::kFronts, schedule);
    const auto found = this->run_by(world.log, Engine::kCholmod, schedule);
    EXPECT_NEAR(found.chi2, expected.chi2, 1e-9 * expected.chi2);
    for (const PoseIndex p : indices(world.log.poses)) {
      const auto& covariance = expected.marginals->poses[p];
      const auto difference = local(expected.map.poses[p], found.map.poses[p]);
      EXPECT_LT(this->in_deviations(difference, covariance), 1e-3) << p.value;
      EXPECT_LE((found.marginals->poses[p] - covariance).norm(), 1e-6 * covariance.norm()) << p.value;
    }
    for (const FeatureIndex f : indices(world.log.features)) {
      const auto& covariance = expected.marginals->features[f];
      EXPECT_LT(this->in_deviations(found.map.features[f] - expected.map.features[f], covariance), 1e-3) << f.value;
      EXPECT_LE((found.marginals->features[f] - covariance).norm(), 1e-6 * covariance.norm()) << f.value;
    }
  }
}

TYPED_TEST(EngineTest, NamesWhatIsFreeToMove) {
  const auto world = testing::small_world<TestFixture::kDim>({.features = 1, .closures = 0, .sessions = 2, .range = 30.0});
  RunOptions options;
  options.split = {SplitRule::kPoses, 6.0};
  const auto by_fronts = run(world.log, options);
  options.solver.engine = Engine::kCholmod;
  const auto by_cholmod = run(world.log, options);
  ASSERT_FALSE(by_fronts);
  ASSERT_FALSE(by_cholmod);
  EXPECT_EQ(by_cholmod.error().message, by_fronts.error().message);
}

}  // namespace
}  // namespace mapjoin
