// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/simulate/manhattan.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <numbers>
#include <stdexcept>
#include <tests/support/dimensions.hpp>
#include <tests/support/same_log.hpp>
#include <tests/support/small_world.hpp>
#include <vector>

namespace mapjoin {
namespace {

using testing::expect_same_log;
using testing::expect_same_observations;
using testing::small_world;

template <typename D>
class WrongMeasurementsTest : public ::testing::Test {};
TYPED_TEST_SUITE(WrongMeasurementsTest, testing::Dimensions);

bool is_local(ClosurePolicy policy) {
  return policy == ClosurePolicy::kLocal || policy == ClosurePolicy::kLocalGroups;
}
bool in_groups(ClosurePolicy policy) {
  return policy == ClosurePolicy::kRandomGroups || policy == ClosurePolicy::kLocalGroups;
}

/// The closures that were planted.
template <int Dim>
std::vector<PoseFactor<Dim>> wrong_ones(const Planted<Dim>& planted) {
  std::vector<PoseFactor<Dim>> wrong;
  const auto closures = planted.log.closures();
  EXPECT_EQ(planted.is_wrong.size(), closures.size());
  for (std::size_t k = 0; k < closures.size(); ++k) {
    if (planted.is_wrong[k]) wrong.push_back(closures[k]);
  }
  return wrong;
}

TYPED_TEST(WrongMeasurementsTest, WrongClosuresStandAfterThoseOfTheLogWhichStayAsTheyAre) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = small_world<kDim>({.closures = 7, .sessions = 2}).log;
  const std::size_t own = log.closures().size();
  for (const auto& [policy, name] : enum_names(ClosurePolicy{})) {
    const auto planted = plant_wrong_closures(log, policy, 50, 1);
    ASSERT_EQ(planted.log.closures().size(), own + 50) << name;
    EXPECT_EQ(wrong_ones(planted).size(), 50u) << name;
    EXPECT_EQ(std::count(planted.is_wrong.begin(), planted.is_wrong.begin() + static_cast<std::ptrdiff_t>(own), true), 0);
    expect_same_observations(planted.log.closures().first(own), log.closures(), {});
    expect_same_observations(planted.log.odometry(), log.odometry(), {});
    expect_same_observations(planted.log.observations(), log.observations(), {});
    EXPECT_EQ(planted.log.sessions.size(), log.sessions.size());
  }
}

TYPED_TEST(WrongMeasurementsTest, RepeatedEdgesAreCounted) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = small_world<kDim>({.poses = 6, .closures = 1}).log;
  // Only ten pairs of six poses are not neighbours: at least 20 of 30 closures repeat an edge.
  EXPECT_GE(plant_wrong_closures(log, ClosurePolicy::kRandom, 30, 1).log.repeated_edges, 20);
}

TYPED_TEST(WrongMeasurementsTest, TheSeedDecidesAndFewerAreTheFirstOfMore) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = small_world<kDim>().log;
  for (const auto& [policy, name] : enum_names(ClosurePolicy{})) {
    const auto planted = plant_wrong_closures(log, policy, 45, 3);
    const auto closures = planted.log.closures();
    expect_same_log(plant_wrong_closures(log, policy, 45, 3).log, planted.log);
    expect_same_observations(plant_wrong_closures(log, policy, 30, 3).log.closures(), closures.first(closures.size() - 15), {});
    EXPECT_NE(plant_wrong_closures(log, policy, 45, 4).log.closures().back().measured.translation,
              closures.back().measured.translation);
  }
}

TYPED_TEST(WrongMeasurementsTest, PoliciesDecideHowFarApartTheEndsAre) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = simulate_manhattan<kDim>({.poses = 1000}).log;
  for (const auto& [policy, name] : enum_names(ClosurePolicy{})) {
    std::int32_t least = 1000;
    std::int32_t most = 0;
    for (const auto& closure : wrong_ones(plant_wrong_closures(log, policy, 20'000, 1))) {
      ASSERT_TRUE(closure.base >= 0 && closure.target < PoseIndex(1000));
      least = std::min(least, closure.target - closure.base);
      most = std::max(most, closure.target - closure.base);
    }
    EXPECT_EQ(least, 2) << name;
    EXPECT_EQ(most == 20, is_local(policy)) << name << ": " << most;
    EXPECT_EQ(most > 900, !is_local(policy)) << name << ": " << most;
  }
}

TYPED_TEST(WrongMeasurementsTest, GroupsAreRunsOfTwentyThatAgree) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = simulate_manhattan<kDim>({.poses = 1000}).log;
  for (const auto& [policy, name] : enum_names(ClosurePolicy{})) {
    const auto wrong = wrong_ones(plant_wrong_closures(log, policy, 400, 1));
    for (std::size_t k = 1; k < wrong.size(); ++k) {
      const bool goes_on = in_groups(policy) && k % 20 != 0;
      EXPECT_EQ(wrong[k].base == wrong[k - 1].base + 1 && wrong[k].target == wrong[k - 1].target + 1, goes_on) << name;
      EXPECT_EQ(wrong[k].measured.translation == wrong[k - 1].measured.translation, goes_on) << name;
    }
  }
}

TYPED_TEST(WrongMeasurementsTest, RelativePosesAreNearTheIdentity) {
  constexpr int kDim = TypeParam::value;
  constexpr std::size_t kCount = 10'000;
  const Log<kDim> log = small_world<kDim>().log;
  PoseVector<kDim> sum = PoseVector<kDim>::Zero();
  PoseVector<kDim> squares = PoseVector<kDim>::Zero();
  PoseVector<kDim> sigma = PoseVector<kDim>::Constant(10.0 * std::numbers::pi / 180.0);
  sigma.template head<kDim>().setConstant(0.3);
  for (const auto& closure : wrong_ones(plant_wrong_closures(log, ClosurePolicy::kRandom, kCount, 1))) {
    const PoseVector<kDim> deviation = local(Pose<kDim>{}, closure.measured).cwiseQuotient(sigma);
    sum += deviation;
    squares += deviation.cwiseAbs2();
  }
  const auto n = static_cast<double>(kCount);
  EXPECT_LT(sum.cwiseAbs().maxCoeff(), 4.0 * std::sqrt(n));
  EXPECT_LT((squares.array() - n).abs().maxCoeff(), 4.0 * std::sqrt(2.0 * n));
}

TYPED_TEST(WrongMeasurementsTest, InformationIsThatOfAnyClosureOfTheLogOrElseOfItsOdometry) {
  constexpr int kDim = TypeParam::value;
  for (const int closures : {5, 0}) {
    const Log<kDim> log = small_world<kDim>({.closures = closures}).log;
    const auto models = closures > 0 ? log.closures() : log.odometry();
    std::vector<int> uses(models.size());
    for (const auto& wrong : wrong_ones(plant_wrong_closures(log, ClosurePolicy::kRandomGroups, 1000, 1))) {
      const auto model =
          std::find_if(models.begin(), models.end(), [&](const auto& own) { return own.information == wrong.information; });
      ASSERT_NE(model, models.end());
      ++uses[static_cast<std::size_t>(model - models.begin())];
    }
    EXPECT_GT(*std::min_element(uses.begin(), uses.end()), 0);
  }
}

TYPED_TEST(WrongMeasurementsTest, ALogWithTooFewPosesOrWithoutEdgesIsRefused) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> short_log = small_world<kDim>({.poses = 21, .closures = 0}).log;
  EXPECT_THROW(plant_wrong_closures(short_log, ClosurePolicy::kLocalGroups, 1, 1), std::invalid_argument);
  EXPECT_NO_THROW(plant_wrong_closures(short_log, ClosurePolicy::kLocal, 1, 1));
  Log<kDim> bare = short_log;
  bare.graph.pose_factors.clear();
  EXPECT_THROW(plant_wrong_closures(bare, ClosurePolicy::kRandom, 1, 1), std::invalid_argument);
  Log<kDim> one_feature = small_world<kDim>({.features = 1}).log;
  EXPECT_THROW(plant_wrong_identities(one_feature, 0.5, 1), std::invalid_argument);
}

TYPED_TEST(WrongMeasurementsTest, AShareOfTheObservationsGetsTheNameOfAnyOtherFeature) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = simulate_manhattan<kDim>({.poses = 1000}).log;
  const auto planted = plant_wrong_identities(log, 0.2, 1);
  const auto observations = planted.log.observations();
  ASSERT_EQ(planted.is_wrong.size(), observations.size());
  std::vector<int> names(log.features.size());
  for (std::size_t k = 0; k < observations.size(); ++k) {
    const auto& own = log.observations()[k];
    EXPECT_EQ(observations[k].target != own.target, planted.is_wrong[k]);
    EXPECT_TRUE(observations[k].base == own.base && observations[k].measured == own.measured);
    if (planted.is_wrong[k]) ++names.at(observations[k].target.position());
  }
  const auto n = static_cast<double>(observations.size());
  const auto wrong = static_cast<double>(std::count(planted.is_wrong.begin(), planted.is_wrong.end(), true));
  EXPECT_NEAR(wrong, 0.2 * n, 4.0 * std::sqrt(0.16 * n));
  const double expected = wrong / static_cast<double>(names.size());
  for (const int count : names) EXPECT_LT(std::abs(count - expected), 6.0 * std::sqrt(expected));
  expect_same_observations(planted.log.edges(), log.edges(), {});
}

TYPED_TEST(WrongMeasurementsTest, TheSeedDecidesOnIdentities) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = small_world<kDim>().log;
  expect_same_log(plant_wrong_identities(log, 0.3, 5).log, plant_wrong_identities(log, 0.3, 5).log);
  EXPECT_NE(plant_wrong_identities(log, 0.3, 5).is_wrong, plant_wrong_identities(log, 0.3, 6).is_wrong);
  expect_same_log(plant_wrong_identities(log, 0.0, 5).log, log);
}

}  // namespace
}  // namespace mapjoin
