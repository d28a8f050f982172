// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/join/robust/doubtful_odometry.hpp>
#include <numbers>
#include <tests/support/closing_world.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/two_drives.hpp>

namespace mapjoin {
namespace {

using testing::Crossing;

/// Four laps of a square, each tied to the one before by a closure every four poses, with a slip of 2 m on the step to pose
/// `slip` and `wrong` wrong closures that bear each other out.
template <int Dim>
Log<Dim> laps(int slip, std::uint64_t wrong = 0) {
  constexpr std::uint64_t kPoses = 160;
  constexpr std::uint64_t kLap = 40;
  const PoseMatrix<Dim> W = 1e4 * PoseMatrix<Dim>::Identity();
  const auto step = [](std::uint64_t to) {
    Pose<Dim> pose;
    pose.translation[0] = 1.0;
    if (to % 10 != 0) return pose;
    PoseVector<Dim> turn = PoseVector<Dim>::Zero();
    turn[Dim == 2 ? 2 : 5] = 0.5 * std::numbers::pi;
    return retract(pose, turn);
  };
  LogBuilder<Dim> builder("laps");
  builder.add_pose({0, 0});
  for (std::uint64_t p = 1; p < kPoses; ++p) {
    Pose<Dim> measured = step(p);
    if (PoseIndex(p) == PoseIndex(slip)) measured.translation[1] += 2.0;
    builder.add_pose_edge({0, p - 1}, {0, p}, measured, W);
  }
  for (std::uint64_t p = 0; p + kLap < kPoses; p += 4) builder.add_pose_edge({0, p}, {0, p + kLap}, Pose<Dim>{}, W);
  Pose<Dim> elsewhere;
  elsewhere.translation[0] = 3.0;
  for (std::uint64_t k = 0; k < wrong; ++k) builder.add_pose_edge({0, 48 + 2 * k}, {0, 98 + 2 * k}, elsewhere, W);
  return std::move(builder).finish().value();
}

template <typename D>
class DoubtfulOdometryTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Two drives, the first of which slips on its step to pose 50, with two closures from every `every`-th of its poses 0 to 79;
  /// with one each it could as well be the second drive that slips.
  static Log<kDim> slipping(double by, std::uint64_t every = 1) {
    std::vector<Crossing> crossings;
    for (std::uint64_t k = 0; k < 80; k += every) crossings.insert(crossings.end(), {{k, k}, {k, k + 20}});
    Log<kDim> log = testing::two_drives<kDim>(100, crossings);
    log.graph.pose_factors[49].measured.translation[0] += by;
    EXPECT_EQ(log.odometry()[49].target, PoseIndex(50));
    return log;
  }
  static void expect_only_the_slip(const Inliers<Log<kDim>>& inliers) {
    ASSERT_EQ(inliers.rejected.size(), 1U);
    EXPECT_EQ(inliers.rejected[0].misfit.kind, PartKind::kOdometry);
    EXPECT_EQ(std::get<PoseIndex>(inliers.rejected[0].misfit.to), PoseIndex(50));
  }
  /// Expects the slip to be the first doubtful step; any others are of the other drive, which closures across the slip cannot
  /// tell from it.
  static void expect_step(const std::vector<PoseIndex>& steps, PoseIndex slip) {
    EXPECT_EQ(steps.at(0), slip);
    for (std::size_t k = 1; k < steps.size(); ++k)
      EXPECT_GE(steps[k], PoseIndex(100)) << "another step of the drive that slips";
  }
  /// Expects the slip of laps() or a step between the same two closures, which no loop tells apart.
  static void expect_between_closures(const Rejected& step, int slip) {
    EXPECT_EQ(step.misfit.kind, PartKind::kOdometry);
    EXPECT_EQ((std::get<PoseIndex>(step.misfit.to).value - 1) / 4, (slip - 1) / 4);
  }
  static std::vector<PoseIndex> doubtful(const Log<kDim>& log) {
    const OdometryChain<kDim> chain(log);
    return doubtful_steps(ClosureSupport<kDim>(chain, log.closures(), 1));
  }
  static RobustOptions all() { return {.odometry = true}; }
};
TYPED_TEST_SUITE(DoubtfulOdometryTest, testing::Dimensions);

TYPED_TEST(DoubtfulOdometryTest, IsTheStepThatLoopsSpeakAgainst) {
  EXPECT_TRUE(this->doubtful(this->slipping(0.0)).empty());
  this->expect_step(this->doubtful(this->slipping(2.0)), PoseIndex(50));
}

/// Of the steps between two closures, which no loop tells apart, only the first is named.
TYPED_TEST(DoubtfulOdometryTest, IsNamedOnceWhereClosuresAreSteppedOver) {
  this->expect_step(this->doubtful(this->slipping(2.0, 4)), PoseIndex(49));
}

/// Right closures before a slip and after it tell nothing of each other; those across it are right, too, but outvoted.
TYPED_TEST(DoubtfulOdometryTest, IsNamedWhereItSetsRightClosuresAgainstEachOther) {
  for (const int slip : {50, 70, 75, 95, 130}) {
    const auto rejected = find_inliers(laps<TypeParam::value>(slip), this->all()).value().rejected;
    ASSERT_EQ(rejected.size(), 1U) << slip;
    this->expect_between_closures(rejected[0], slip);
  }
}

TYPED_TEST(DoubtfulOdometryTest, IsNamedBesideClosuresThatAreWrongTogether) {
  const auto rejected = find_inliers(laps<TypeParam::value>(75, 8), this->all()).value().rejected;
  ASSERT_EQ(rejected.size(), 9U);
  const auto is_odometry = [](const Rejected& one) { return one.misfit.kind == PartKind::kOdometry; };
  ASSERT_EQ(std::ranges::count_if(rejected, is_odometry), 1);
  this->expect_between_closures(*std::ranges::find_if(rejected, is_odometry), 75);
}

/// Closures with standard deviations ten times as large: no two of them speak against a step, all together do.
TYPED_TEST(DoubtfulOdometryTest, IsFoundByTheVerdictWhereNoLoopTells) {
  auto log = this->slipping(0.5);
  const std::size_t first = log.odometry().size();
  for (auto& closure : std::span(log.graph.pose_factors).subspan(first, log.closures().size())) closure.information *= 0.01;
  EXPECT_TRUE(this->doubtful(log).empty());
  this->expect_only_the_slip(find_inliers(log, this->all()).value());
}

TYPED_TEST(DoubtfulOdometryTest, BecomesAClosureWhereTheDriveIsCut) {
  const auto log = this->slipping(2.0);
  const auto cut = cut_before(log, {50});
  EXPECT_EQ(cut.odometry().size() + 1, log.odometry().size());
  EXPECT_EQ(cut.closures().size(), log.closures().size() + 1);
  EXPECT_EQ(cut.sessions.size(), log.sessions.size() + 1);
  EXPECT_EQ(cut.poses[49], log.poses[49]);
  EXPECT_TRUE(this->doubtful(cut).empty());
}

TYPED_TEST(DoubtfulOdometryTest, IsRejectedAndNothingElse) {
  const auto log = this->slipping(2.0);
  const auto inliers = find_inliers(log, this->all()).value();
  this->expect_only_the_slip(inliers);
  EXPECT_EQ(inliers.input.poses, log.poses);
  EXPECT_EQ(inliers.input.closures().size(), log.closures().size());
  EXPECT_EQ(inliers.input.odometry().size() + 1, log.odometry().size());
  const auto believed = find_inliers(log, RobustOptions{}).value().rejected;  // odometry is believed unless it is asked for
  EXPECT_FALSE(believed.empty());
  for (const Rejected& rejected : believed) EXPECT_EQ(rejected.misfit.kind, PartKind::kClosure);
}

TYPED_TEST(DoubtfulOdometryTest, OfConsistentWorldsIsHardlyEverRejected) {
  constexpr int kWorlds = 100;
  int worlds_that_lose = 0;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    const testing::ClosingWorld<TypeParam::value> world(TypeParam::value == 2 ? 60 : 25, seed, 12);
    worlds_that_lose += find_inliers(world.log, this->all()).value().rejected.empty() ? 0 : 1;
  }
  EXPECT_LE(worlds_that_lose, 0.01 * kWorlds + 2.5 * std::sqrt(0.01 * kWorlds));
}

}  // namespace
}  // namespace mapjoin
