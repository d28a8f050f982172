// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/robust/robust_map.hpp>
#include <tests/support/changed_log.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

/// Noise (m, rad) so large that a single step does not reach the minimum.
constexpr double kRoughNoise = 0.03;

template <typename D>
class RobustMapTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  TruncatedJoin<kDim> join() const { return TruncatedJoin<kDim>(world.log, world.truth, {}, Engine::kFronts); }

  testing::SmallWorld<kDim> world =
      testing::small_world<kDim>({.poses = 30, .features = 0, .closures = 15, .noise = kRoughNoise});
  Gates gates;
};
TYPED_TEST_SUITE(RobustMapTest, testing::Dimensions);

TYPED_TEST(RobustMapTest, EndsAtTheOptimumOfWhatPassesItsTest) {
  const auto right = testing::without_closure(this->world.log, 2);
  testing::spoil_closure(this->world.log, 2, 0.5);
  auto join = this->join();
  join.settle({});
  this->gates.last = OfKinds{0.7 * join.closure_tests()[2].chi2, 1e9};
  join.graduate(*this->gates.last, {});
  ASSERT_TRUE(join.counts(2)) << "its residual does not show that it is wrong: only its leave-one-out test does";
  ASSERT_TRUE(settle(join, this->gates, "a log", {}));
  for (std::size_t k = 0; k < join.closure_tests().size(); ++k) EXPECT_EQ(join.counts(k), k != 2) << k;
  const auto optimum = testing::full_slam(right).optimum(this->world.truth);
  EXPECT_LT(testing::largest_difference(join.system().estimate(), optimum), 1e-4 * kRoughNoise);
}

TYPED_TEST(RobustMapTest, LetsClosuresInAgainOnlyWhereAllAreTriedAgain) {
  testing::spoil_closure(this->world.log, 2, 5.0);
  for (const bool is_last : {false, true}) {
    Gates gates;
    gates.widest = {40.0, 40.0};
    if (is_last) gates.last = gates.widest;
    auto join = this->join();
    join.settle({});
    ASSERT_TRUE(join.drop_closures(0.0));
    ASSERT_TRUE(settle(join, gates, "a log", {}));
    for (std::size_t k = 0; k < join.closure_tests().size(); ++k) EXPECT_EQ(join.counts(k), is_last && k != 2) << k;
  }
}

/// Nearly all closures fit far more closely than their covariances say. Two do not, the second of which is within the gate
/// while the first one counts.
TYPED_TEST(RobustMapTest, NarrowsTheGateOfClosuresByThoseThatRemain) {
  this->world = testing::small_world<TypeParam::value>({.poses = 30, .features = 0, .closures = 30, .noise = 1e-3});
  testing::spoil_closure(this->world.log, 2, 0.3);
  testing::spoil_closure(this->world.log, 3, 0.05);
  this->gates.widest = {10.0, 10.0};
  auto join = this->join();
  ASSERT_TRUE(settle(join, this->gates, "a log", {}));
  EXPECT_FALSE(join.counts(2));
  EXPECT_FALSE(join.counts(3));
  EXPECT_LT(join.closure_tests()[3].chi2, this->gates.widest.closures);
  EXPECT_GE(join.counting_closure_tests().size(), 25U);
}

TYPED_TEST(RobustMapTest, SaysThatAStopEndedIt) {
  auto join = this->join();
  std::stop_source stopped;
  stopped.request_stop();
  const auto settled = settle(join, this->gates, "a log", stopped.get_token());
  ASSERT_FALSE(settled);
  EXPECT_EQ(settled.error().kind, ErrorKind::kInterrupted);
}

}  // namespace
}  // namespace mapjoin
