// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/run.hpp>
#include <span>
#include <tests/join/robust/truncated_join_fixture.hpp>
#include <tests/support/changed_log.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <utility>

namespace mapjoin {
namespace {

using testing::kNoise;
using testing::kThreshold;
using testing::kThresholds;

template <typename D>
class TruncatedJoinTest : public testing::TruncatedJoinFixture<D> {
 protected:
  static constexpr int kDim = D::value;

  static void expect_alike(std::span<const PartTest> tests, std::span<const PartTest> expected, double share) {
    ASSERT_EQ(tests.size(), expected.size());
    for (std::size_t k = 0; k < tests.size(); ++k) {
      EXPECT_NEAR(tests[k].chi2, expected[k].chi2, share * expected[k].chi2) << k;
    }
  }
  static double chi2_of(const Log<kDim>& log) {
    RunOptions options = without_verdict();
    options.solver.relative_chi2 = 1e-14;
    return solve(log, options).value().chi2;
  }
};
TYPED_TEST_SUITE(TruncatedJoinTest, testing::Dimensions);

TYPED_TEST(TruncatedJoinTest, CountsOutWhatDoesNotFitAndKeepsTheOthers) {
  for (const double metres : {0.2, 5.0}) {
    auto world = this->world();
    testing::spoil_closure(world.log, 2, metres);
    testing::spoil_observation(world.log, 7, metres);
    auto join = this->join_of(world);
    join.graduate(kThresholds, {});
    EXPECT_EQ(this->closures_that_do_not_count(join), std::vector<std::size_t>{2}) << metres;
    EXPECT_FALSE(join.observations_count()[7]);
    EXPECT_EQ(this->observations_that_count(join), std::ssize(world.log.observations()) - 1);
    EXPECT_LT(testing::largest_difference(join.system().estimate(), world.truth), 0.01);
  }
}

TYPED_TEST(TruncatedJoinTest, KeepsAllOfALogThatFits) {
  const auto world = this->world();
  auto join = this->join_of(world);
  join.graduate(kThresholds, {});
  EXPECT_TRUE(this->closures_that_do_not_count(join).empty());
  EXPECT_EQ(this->observations_that_count(join), std::ssize(world.log.observations()));
}

TYPED_TEST(TruncatedJoinTest, CountsOutAClosureWhoseChi2IsInfinite) {
  auto world = this->world();
  testing::spoil_closure(world.log, 2, 1e10);
  world.log.graph.pose_factors[world.log.odometry().size() + 2].information.setIdentity();
  world.log.graph.pose_factors[world.log.odometry().size() + 2].information *= 1e300;
  auto join = this->join_of(world);
  join.graduate(kThresholds, {});
  EXPECT_FALSE(join.counts(2));
}

TYPED_TEST(TruncatedJoinTest, HoldsTheStartOfASessionByNoMoreThanATypicalStep) {
  constexpr int kDim = TypeParam::value;
  auto world = testing::small_world<kDim>({.poses = 30, .features = 0, .closures = 0, .sessions = 2, .noise = kNoise});
  auto& edges = world.log.graph.pose_factors;
  for (std::size_t k = 0; k < edges.size(); k += 3) edges[k].information = 1e12 * PoseMatrix<kDim>::Identity();  // standing
  for (int k = 0; k < 10; ++k) {
    const PoseIndex base(3 * k), target(59 - 2 * k);
    edges.push_back(
        {base, target, between(world.truth.poses[base], world.truth.poses[target]), 25.0 * PoseMatrix<kDim>::Identity(), {}});
  }
  put_in_order(world.log);
  const Values<kDim> truth = world.truth;
  for (int p = 30; p < 60; ++p) world.truth.poses[PoseIndex(p)].translation[0] += 20.0;
  auto join = this->join_of(world);
  join.settle({});
  EXPECT_LT(testing::largest_difference(join.system().estimate(), truth), 0.01);
}

TYPED_TEST(TruncatedJoinTest, DoesNotTestAnObservationThatAloneCountsOfItsFeature) {
  const auto world = this->world();
  const FeatureIndex feature = world.log.observations()[0].target;
  std::vector<bool> count(world.log.observations().size(), true);
  for (std::size_t k = 1; k < count.size(); ++k) count[k] = world.log.observations()[k].target != feature;
  auto join = this->join_of(world, count);
  join.settle({});
  EXPECT_EQ(join.observation_tests()[0].rows, 0);
}

TYPED_TEST(TruncatedJoinTest, GivesKindsThresholdsOfTheirOwn) {
  auto closure = this->world();
  testing::spoil_closure(closure.log, 2, 0.05);
  auto of_closures = this->join_of(closure);
  of_closures.graduate({kThreshold, 1e9}, {});
  EXPECT_EQ(this->closures_that_do_not_count(of_closures), std::vector<std::size_t>{2});
  EXPECT_EQ(this->observations_that_count(of_closures), std::ssize(closure.log.observations()));
  auto observation = this->world();
  testing::spoil_observation(observation.log, 7, 0.05);
  auto of_observations = this->join_of(observation);
  of_observations.graduate({1e9, kThreshold}, {});
  EXPECT_TRUE(this->closures_that_do_not_count(of_observations).empty());
  EXPECT_FALSE(of_observations.observations_count()[7]);
}

TYPED_TEST(TruncatedJoinTest, TestsWhatCountsAgainstAllOthers) {
  const auto world = this->world();
  auto join = this->join_of(world);
  join.settle({});
  ASSERT_TRUE(join.is_tested());
  const double chi2 = this->chi2_of(world.log);
  for (std::size_t k = 0; k < join.closure_tests().size(); ++k) {
    const double gain = chi2 - this->chi2_of(testing::without_closure(world.log, k));
    EXPECT_NEAR(join.closure_tests()[k].chi2, gain, 1e-3 * gain) << "closure " << k;
  }
  for (const std::size_t k : {0U, 9U, 20U}) {
    const double gain = chi2 - this->chi2_of(testing::without_observation(world.log, k));
    EXPECT_NEAR(join.observation_tests()[k].chi2, gain, 1e-3 * gain) << "observation " << k;
  }
}

TYPED_TEST(TruncatedJoinTest, TestsWhatDoesNotCountAgainstAllThatCounts) {
  auto world = this->world();
  testing::spoil_closure(world.log, 2, 0.01);
  testing::spoil_observation(world.log, 7, 0.01);
  auto join = this->join_of(world);
  join.graduate(kThresholds, {});
  join.settle({});
  const Log<TypeParam::value> without_closure = testing::without_closure(world.log, 2);
  const double chi2 = this->chi2_of(testing::without_observation(without_closure, 7));
  const double more_with_closure = this->chi2_of(testing::without_observation(world.log, 7)) - chi2;
  EXPECT_NEAR(join.closure_tests()[2].chi2, more_with_closure, 0.01 * more_with_closure);
  const double more_with_observation = this->chi2_of(without_closure) - chi2;
  EXPECT_NEAR(join.observation_tests()[7].chi2, more_with_observation, 0.01 * more_with_observation);
}

TYPED_TEST(TruncatedJoinTest, SettlesByAStepWhereAllIsLinear) {
  auto world = this->world();
  testing::spoil_closure(world.log, 2, 0.01);
  auto settled = this->join_of(world);
  settled.settle({});
  auto by_a_step = this->join_of(world);
  by_a_step.settle_by_a_step({});
  ASSERT_TRUE(by_a_step.is_tested());
  const auto& optimum = settled.system().estimate();
  const double moved = testing::largest_difference(optimum, world.truth);
  EXPECT_LT(testing::largest_difference(by_a_step.system().estimate(), optimum), 0.01 * moved);
  this->expect_alike(by_a_step.closure_tests(), settled.closure_tests(), 0.05);
  this->expect_alike(by_a_step.observation_tests(), settled.observation_tests(), 0.05);
}

TYPED_TEST(TruncatedJoinTest, SettlesByAStepWithoutWhatDoesNotCount) {
  auto world = this->world();
  testing::spoil_closure(world.log, 2, 0.01);
  auto settled = this->join_of(world);
  auto by_a_step = this->join_of(world);
  for (auto* join : {&settled, &by_a_step}) {
    join->settle({});  // the wrong closure pulls until it is dropped
    ASSERT_TRUE(join->drop_closures(0.9 * join->closure_tests()[2].chi2));
    ASSERT_EQ(this->closures_that_do_not_count(*join), std::vector<std::size_t>{2});
  }
  settled.settle({});
  by_a_step.settle_by_a_step({});
  const auto& optimum = settled.system().estimate();
  EXPECT_LT(testing::largest_difference(by_a_step.system().estimate(), optimum), 0.1 * kNoise);
  this->expect_alike(by_a_step.closure_tests(), settled.closure_tests(), 0.1);
}

TYPED_TEST(TruncatedJoinTest, DropsTheFarthestClosureAlone) {
  auto world = this->world();
  testing::spoil_closure(world.log, 2, 0.01);
  testing::spoil_closure(world.log, 4, 0.02);
  auto join = this->join_of(world);
  join.settle({});
  ASSERT_GT(join.closure_tests()[2].chi2, testing::kThreshold);
  EXPECT_TRUE(join.drop_farthest_closure(testing::kThreshold));
  EXPECT_EQ(this->closures_that_do_not_count(join), std::vector<std::size_t>{4});
  join.settle({});
  EXPECT_TRUE(join.drop_farthest_closure(testing::kThreshold));
  join.settle({});
  EXPECT_EQ(this->closures_that_do_not_count(join), (std::vector<std::size_t>{2, 4}));
  EXPECT_FALSE(join.drop_farthest_closure(testing::kThreshold));
}

TYPED_TEST(TruncatedJoinTest, TakesNoStepThatWouldRaiseChi2) {
  const auto world = this->world();
  const auto slam = testing::full_slam(world.log);
  for (const double turn : {1.0, 2.0, 3.0}) {  // so far off that the linearised problem differs
    auto start = world.truth;
    PoseVector<TypeParam::value> turned = PoseVector<TypeParam::value>::Zero();
    turned[TypeParam::value] = turn;
    for (const PoseIndex p : indices(start.poses)) {
      if (p.value >= 10) start.poses[p] = retract(start.poses[p], turned);
    }
    TruncatedJoin<TypeParam::value> join(world.log, start, {}, Engine::kFronts);
    join.settle_by_a_step({});
    EXPECT_LE(slam.linearise(join.system().estimate()).chi2, slam.linearise(start).chi2) << turn;
  }
}

TYPED_TEST(TruncatedJoinTest, HoldsFeaturesSoWeaklyThatTheOptimumStays) {
  const auto world = this->world();
  auto far = world;
  for (auto& feature : far.truth.features) feature.array() += 0.01;  // a hundred times the noise
  auto join = this->join_of(far);
  join.settle({});
  const auto optimum = testing::full_slam(world.log).optimum(world.truth);
  EXPECT_LT(testing::largest_difference(join.system().estimate(), optimum), 1e-3 * kNoise);
}

TYPED_TEST(TruncatedJoinTest, IsTestedThoughNothingOfAFeatureCounts) {
  const auto world = this->world();
  const auto observations = world.log.observations();
  const FeatureIndex hidden = observations[0].target;
  std::vector<bool> count;
  for (const auto& o : observations) count.push_back(o.target != hidden);
  auto join = this->join_of(world, count);
  join.settle({});
  ASSERT_TRUE(join.is_tested());
  EXPECT_LT((join.system().estimate().features[hidden] - world.truth.features[hidden]).norm(), 1e-6) << "it stays";
  EXPECT_TRUE(join.readmit(kThresholds));
  EXPECT_EQ(this->observations_that_count(join), std::ssize(observations));
  EXPECT_FALSE(join.readmit(kThresholds)) << "all count";
}

TYPED_TEST(TruncatedJoinTest, IsTestedThoughAnEdgeLeavesADirectionFree) {
  constexpr int kDim = TypeParam::value;
  auto world = testing::small_world<kDim>({.poses = 30, .features = 0, .closures = 0, .noise = kNoise});
  world.log.graph.pose_factors[9].information.row(1).setZero();
  world.log.graph.pose_factors[9].information.col(1).setZero();
  auto join = this->join_of(world);
  join.settle({});
  EXPECT_TRUE(join.is_tested());
  EXPECT_LT(testing::largest_difference(join.system().estimate(), world.truth), 0.1);
}

}  // namespace
}  // namespace mapjoin
