// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <tests/support/closing_world.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class InliersTest : public ::testing::Test {};
TYPED_TEST_SUITE(InliersTest, testing::Dimensions);

TYPED_TEST(InliersTest, LosesNothingOfALogThatFits) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = testing::small_world<kDim>({.poses = 60, .features = 20, .closures = 12, .range = 3.0}).log;
  const Inliers<Log<kDim>> inliers = find_inliers(log, RobustOptions{}).value();
  EXPECT_TRUE(inliers.rejected.empty());
  EXPECT_EQ(inliers.input.closures().size(), log.closures().size());
  EXPECT_EQ(inliers.input.observations().size(), log.observations().size());
}

TYPED_TEST(InliersTest, OfAHundredConsistentWorldsHardlyMoreThanOneLosesAnything) {
  constexpr int kWorlds = TypeParam::value == 2 ? 1000 : 300;
  int worlds_that_lose = 0;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const testing::ClosingWorld<TypeParam::value> world(TypeParam::value == 2 ? 60 : 25, seed, 12);
    worlds_that_lose += find_inliers(world.log, RobustOptions{}).value().rejected.empty() ? 0 : 1;
  }
  this->RecordProperty("worlds_that_lose", worlds_that_lose);
  EXPECT_LE(worlds_that_lose, 0.01 * kWorlds + 2.5 * std::sqrt(0.01 * kWorlds));
}

TYPED_TEST(InliersTest, RejectsObservationsUnderTheNamesOfOtherFeatures) {
  constexpr int kDim = TypeParam::value;
  ManhattanOptions options;
  options.poses = 300;
  options.side = 10.0;
  options.range = 4.0;  // every feature is seen several times
  const Log<kDim> log = simulate_manhattan<kDim>(options).log;
  const auto planted = plant_wrong_identities(log, 0.05, 1);
  const Inliers<Log<kDim>> inliers = find_inliers(planted.log, RobustOptions{}).value();
  std::size_t wrong = 0;
  for (const bool is_wrong : planted.is_wrong) wrong += is_wrong ? 1 : 0;
  ASSERT_GT(wrong, 10U);
  EXPECT_GE(inliers.rejected.size(), 9 * wrong / 10);
  EXPECT_LE(inliers.rejected.size(), wrong + 2);
}

TYPED_TEST(InliersTest, EndsOnceAStopIsRequested) {
  const testing::ClosingWorld<TypeParam::value> world(25, 1, 12);
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(find_inliers(world.log, RobustOptions{}, source.get_token()).error().kind, ErrorKind::kInterrupted);
}

TEST(RobustOptionsTest, WantAConfidenceBetweenZeroAndOne) {
  EXPECT_TRUE(RobustOptions{}.validate().empty());
  EXPECT_FALSE(RobustOptions{.confidence = 1.0}.validate().empty());
  EXPECT_FALSE(RobustOptions{.confidence = 0.0}.validate().empty());
}

}  // namespace
}  // namespace mapjoin
