// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <tests/support/closing_world.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <tests/support/two_drives.hpp>

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

/// A log with a step that measures no rotation, which only closures across it do; the first map has none of these.
TYPED_TEST(InliersTest, AreFoundWhereOdometryLeavesSomethingFree) {
  constexpr int kDim = TypeParam::value;
  auto world = testing::small_world<kDim>({.poses = 60, .features = 0, .closures = 0});
  const auto close = [&](int base, int target, double wrong_by) {
    PoseFactor<kDim> closure = world.log.graph.pose_factors.front();
    closure.base = PoseIndex(base);
    closure.target = PoseIndex(target);
    closure.measured = between(world.truth.poses[closure.base], world.truth.poses[closure.target]);
    closure.measured.translation[0] += wrong_by;
    world.log.graph.pose_factors.push_back(closure);
  };
  world.log.graph.pose_factors[30].information.bottomRows(kRotationDof<kDim>).setZero();
  world.log.graph.pose_factors[30].information.rightCols(kRotationDof<kDim>).setZero();
  for (int k = 0; k < 12; ++k) close(k, k + 14, 0.0);
  close(26, 36, 0.0);
  for (int k = 0; k < 4; ++k) close(k, 45 + 3 * k, 20.0 + 5.0 * k);
  put_in_order(world.log);
  const auto found = find_inliers(world.log, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->rejected.size(), 4U);
  EXPECT_EQ(found->input.closures().size(), 13U);
}

/// A closure between two poses, as the truth has it; with `wrong_by` (m) added to its position.
template <int Dim>
PoseFactor<Dim> closure_of(const Values<Dim>& truth, int base, int target, const PoseMatrix<Dim>& W, double wrong_by = 0.0) {
  PoseFactor<Dim> closure{PoseIndex(base), PoseIndex(target), {}, W, {}};
  closure.measured = between(truth.poses[closure.base], truth.poses[closure.target]);
  closure.measured.translation[0] += wrong_by;
  return closure;
}

/// A ring of sharp closures whose last one is wrong: each of them seems as wrong as the others.
TYPED_TEST(InliersTest, LoseOneClosureOfARingThatDoesNotClose) {
  constexpr int kDim = TypeParam::value;
  auto world = testing::small_world<kDim>({.poses = 17, .features = 0, .closures = 0});
  const PoseMatrix<kDim> sharp = 1e6 * PoseMatrix<kDim>::Identity();
  auto& factors = world.log.graph.pose_factors;
  for (int k = 0; k < 16; k += 2) factors.push_back(closure_of(world.truth, k, k + 2, sharp));
  factors.push_back(closure_of(world.truth, 0, 16, sharp, 0.03));
  put_in_order(world.log);
  EXPECT_EQ(find_inliers(world.log, {}).value().rejected.size(), 1U);
}

TYPED_TEST(InliersTest, KeepClosuresThatMeasureRotationOnlyHoweverFarApartTheirPosesAre) {
  constexpr int kDim = TypeParam::value;
  constexpr double kLarger = 100.0;
  auto world = testing::small_world<kDim>({.poses = 60, .features = 0, .closures = 0, .noise = 1e-4});
  for (PoseFactor<kDim>& edge : world.log.graph.pose_factors) edge.measured.translation *= kLarger;
  PoseMatrix<kDim> W = PoseMatrix<kDim>::Zero();
  W.diagonal().template tail<kRotationDof<kDim>>().setConstant(1e6);
  for (int k = 0; k < 12; ++k) {
    world.log.graph.pose_factors.push_back(closure_of(world.truth, k, k + 30, W));
    world.log.graph.pose_factors.back().measured.translation.setZero();
  }
  put_in_order(world.log);
  EXPECT_TRUE(find_inliers(world.log, {}).value().rejected.empty());
}

TYPED_TEST(InliersTest, KeepClosuresThatDoNotMeasureAlongACorridor) {
  constexpr int kDim = TypeParam::value;
  auto log = testing::two_drives<kDim>(600, {{0, 0}, {300, 300}, {599, 599}});  // straight, and without noise
  PoseMatrix<kDim> across = 1e6 * PoseMatrix<kDim>::Identity();
  across(0, 0) = 0.0;
  for (int k = 0; k < 12; ++k) log.graph.pose_factors.push_back({PoseIndex(10 * k), PoseIndex(10 * k + 400), {}, across, {}});
  put_in_order(log);
  EXPECT_TRUE(find_inliers(log, {}).value().rejected.empty());
}

TYPED_TEST(InliersTest, RejectASharpWrongClosureOfALongLoop) {
  constexpr int kDim = TypeParam::value;
  auto world = testing::small_world<kDim>({.poses = 60, .features = 0, .closures = 0, .noise = 1e-4});
  for (PoseFactor<kDim>& edge : world.log.graph.pose_factors) edge.information *= 1e6;
  const PoseMatrix<kDim> W = 1e4 * world.log.odometry()[0].information;
  world.log.graph.pose_factors.push_back(closure_of(world.truth, 0, 59, W, 1.0));
  put_in_order(world.log);
  EXPECT_EQ(find_inliers(world.log, {}).value().rejected.size(), 1U);
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

/// Two robots without features that see each other at their first `meetings` poses.
template <int Dim>
Log<Dim> meeting_robots(int meetings) {
  auto world = testing::small_world<Dim>({.poses = 60, .features = 0, .closures = 6, .sessions = 2});
  testing::Random random(3);
  PoseMatrix<Dim> W = PoseMatrix<Dim>::Zero();
  W.diagonal().template head<Dim>().setConstant(1.0 / (0.05 * 0.05));
  for (int k = 0; k < meetings; ++k) {
    const PoseIndex base(k);
    const PoseIndex target(k + 60);
    Pose<Dim> seen;
    seen.translation = between(world.truth.poses[base], world.truth.poses[target]).translation + random.vector<Dim>(0.05);
    world.log.graph.pose_factors.push_back({base, target, seen, W});
  }
  put_in_order(world.log);
  return world.log;
}

TYPED_TEST(InliersTest, AreAllMeetingsOfRobotsThatNothingElseTies) {
  const auto found = find_inliers(meeting_robots<TypeParam::value>(40), {}).value();
  EXPECT_TRUE(found.rejected.empty());
}

TYPED_TEST(InliersTest, AreNotMeetingsWithSomethingElse) {
  auto log = meeting_robots<TypeParam::value>(40);
  std::vector<PoseFactor<TypeParam::value>*> wrong;
  for (auto& edge : log.graph.pose_factors) {
    if (!measures_rotation(edge) && edge.base.value % 10 == 5) wrong.push_back(&edge);
  }
  for (auto* edge : wrong) edge->measured.translation[0] += 5.0;
  const auto found = find_inliers(log, {}).value();
  EXPECT_EQ(found.rejected.size(), wrong.size());
  for (const Rejected& one : found.rejected) {
    EXPECT_EQ(one.misfit.rows, TypeParam::value);
    EXPECT_EQ(one.misfit.from.value % 10, 5);
  }
}

}  // namespace
}  // namespace mapjoin
