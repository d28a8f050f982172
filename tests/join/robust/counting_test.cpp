// SPDX-License-Identifier: BSD-3-Clause
// Closures and observations that count in a truncated join: those that are dropped, and those that are let in again.
#include <gtest/gtest.h>

#include <algorithm>
#include <tests/join/robust/truncated_join_fixture.hpp>
#include <tests/support/changed_log.hpp>
#include <tests/support/dimensions.hpp>
#include <utility>

namespace mapjoin {
namespace {

using testing::kThreshold;
using testing::kThresholds;

template <typename D>
class CountingTest : public testing::TruncatedJoinFixture<D> {};
TYPED_TEST_SUITE(CountingTest, testing::Dimensions);

TYPED_TEST(CountingTest, LetsNoWrongObservationCountAgain) {
  auto world = this->world();
  testing::spoil_observation(world.log, 7, 1.0);
  std::vector<bool> count(world.log.observations().size(), true);
  count[7] = count[8] = false;
  auto join = this->join_of(world, count);
  join.settle({});
  EXPECT_TRUE(join.readmit(kThresholds));
  EXPECT_FALSE(join.observations_count()[7]);
  EXPECT_TRUE(join.observations_count()[8]);
}

TYPED_TEST(CountingTest, LetsAClosureCountAgainThatFitsTheOthers) {
  auto world = this->world();
  testing::spoil_closure(world.log, 2, 5.0);
  auto join = this->join_of(world);
  join.settle({});
  ASSERT_TRUE(join.drop_closures(0.0));
  join.settle({});
  EXPECT_FALSE(join.readmit({0.0, kThreshold})) << "closures are not meant";
  EXPECT_TRUE(join.readmit(kThresholds));
  EXPECT_EQ(this->closures_that_do_not_count(join), std::vector<std::size_t>{2});
}

TYPED_TEST(CountingTest, DropsOnlyTheFarthestObservationsAtOnce) {
  auto world = this->world();
  for (const std::size_t k : {7u, 20u, 35u}) testing::spoil_observation(world.log, k, 0.01);
  auto join = this->join_of(world);
  join.settle({});
  const std::vector<PartTest> tests(join.observation_tests().begin(), join.observation_tests().end());
  const double worst = std::ranges::max(tests, {}, &PartTest::chi2).chi2;
  EXPECT_FALSE(join.drop_observations(1.01 * worst));
  constexpr double kShare = 1e-3;
  EXPECT_TRUE(join.drop_observations(kShare * worst));
  EXPECT_TRUE(this->closures_that_do_not_count(join).empty());
  std::size_t dropped = 0;
  std::size_t spared = 0;
  for (std::size_t k = 0; k < tests.size(); ++k) {
    EXPECT_EQ(join.observations_count()[k], tests[k].chi2 < 0.5 * worst) << k;
    if (!join.observations_count()[k]) ++dropped;
    if (join.observations_count()[k] && tests[k].chi2 > kShare * worst) ++spared;
  }
  EXPECT_GT(dropped, 1U);
  EXPECT_GT(spared, 0U) << "that are beyond, too";
}

/// The closures that are dropped from a world where the chi2 of the worst one, closure 1, is `excess` times the threshold.
/// Closure 4 has two thirds of that chi2, closure 5 a quarter, and no other a tenth.
template <typename D>
class DropTest : public testing::TruncatedJoinFixture<D> {
 protected:
  std::vector<std::size_t> dropped(double excess) {
    auto world = this->world();
    for (const auto& [closure, metres] : {std::pair(1U, 0.1), std::pair(4U, 0.08), std::pair(5U, 0.05)}) {
      world.log.graph.pose_factors[world.log.odometry().size() + closure].information.setIdentity();
      testing::spoil_closure(world.log, closure, metres);
    }
    auto join = this->join_of(world);
    join.settle({});
    const double worst = join.closure_tests()[1].chi2;
    EXPECT_EQ(join.drop_closures(worst / excess), excess > 1.0);
    return this->closures_that_do_not_count(join);
  }
};
TYPED_TEST_SUITE(DropTest, testing::Dimensions);

TYPED_TEST(DropTest, LeavesNothingOutThatPassesItsTest) {
  EXPECT_TRUE(this->dropped(0.9).empty());
}

TYPED_TEST(DropTest, LeavesOutAllThatAreBeyond) {
  EXPECT_EQ(this->dropped(10.0), (std::vector<std::size_t>{1, 4, 5}));
}

TYPED_TEST(DropTest, LeavesOutTheWorstAloneWhereNoOtherIsBeyond) {
  EXPECT_EQ(this->dropped(1.4), std::vector<std::size_t>{1});
}

}  // namespace
}  // namespace mapjoin
