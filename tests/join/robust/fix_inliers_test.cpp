// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/join/robust/fix_inliers.hpp>
#include <set>
#include <span>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/gps_world.hpp>

namespace mapjoin::testing {
namespace {

template <typename D>
class FixInliers : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Moves every `nth` fix by 10 to 100 m in a random direction. Returns the places of these fixes.
  static std::set<std::size_t> spoil(std::size_t nth, Log<kDim>& log) {
    RandomStream random(9, 0);
    std::set<std::size_t> spoiled;
    const std::size_t first = log.edges().size();
    for (std::size_t f = 0; first + f < log.graph.pose_factors.size(); f += nth) {
      Point<kDim> direction;
      for (int i = 0; i < kDim; ++i) direction[i] = random.normal();
      log.graph.pose_factors[first + f].measured.translation += random.uniform(10.0, 100.0) * direction.normalized();
      spoiled.insert(f);
    }
    return spoiled;
  }
  static std::set<std::size_t> found_in(const Log<kDim>& log, const RobustOptions& options = {}) {
    std::set<std::size_t> found;
    const auto rejected = find_wrong_fixes(log, options);
    EXPECT_TRUE(rejected) << rejected.error().message;
    for (const RejectedFix& fix : *rejected) found.insert(fix.prior);
    return found;
  }
};
TYPED_TEST_SUITE(FixInliers, Dimensions);

TYPED_TEST(FixInliers, RightFixesAreKept) {
  EXPECT_TRUE(this->found_in(gps_world<TestFixture::kDim>().log).empty());
}

TYPED_TEST(FixInliers, WrongFixesAreFound) {
  for (const std::size_t nth : {10U, 5U, 3U}) {
    auto world = gps_world<TestFixture::kDim>({.poses = 400, .between = 2});
    const auto spoiled = this->spoil(nth, world.log);
    EXPECT_EQ(this->found_in(world.log), spoiled) << "one of " << nth;
  }
}

/// Fixes a hundredth as far off as odometry is from one to the next: only with the covariance of what the rest predicts for a
/// fix does the fix fit.
TYPED_TEST(FixInliers, PreciseFixesAreJudgedByWhatOdometryBetweenThemAllows) {
  RobustOptions options;
  options.confidence = 0.9999;  // so that none of ten worlds loses a right fix by chance
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    auto log = gps_world<TestFixture::kDim>({.poses = 800, .between = 80, .deviation = 0.02, .seed = seed}).log;
    log.features.clear();
    log.initial.features.clear();
    log.graph.feature_factors.clear();
    EXPECT_TRUE(this->found_in(log, options).empty()) << seed;
    constexpr std::size_t kWrong = 5;
    log.graph.pose_factors[log.edges().size() + kWrong].measured.translation[0] += 50.0;
    const auto rejected = find_wrong_fixes(log, options).value();
    ASSERT_EQ(rejected.size(), 1U) << seed;
    EXPECT_EQ(rejected.front().prior, kWrong) << seed;
    EXPECT_LT(rejected.front().chi2, 1e5) << "not the 6e6 of its own covariance alone, seed " << seed;
  }
}

/// A drive in two halves that neither odometry nor features tie: each half is placed by its own fixes.
TYPED_TEST(FixInliers, WrongFixesAreFoundInPartsThatOnlyFixesTie) {
  auto world = gps_world<TestFixture::kDim>({.poses = 400, .between = 2});
  const auto is_late = [](PoseIndex pose) { return pose.value >= 200; };
  std::erase_if(world.log.graph.pose_factors,
                [&](const auto& edge) { return edge.base != kWorld && is_late(edge.base) != is_late(edge.target); });
  std::erase_if(world.log.graph.feature_factors, [&](const auto& seen) { return is_late(seen.base); });
  const auto spoiled = this->spoil(5, world.log);
  EXPECT_EQ(this->found_in(world.log), spoiled);
}

/// Two fixes of five are at one place thousands of kilometres away, as of a receiver that reports the origin of its frame while
/// it has no fix.
TYPED_TEST(FixInliers, WrongFixesThatAgreeAreFoundWhileTheyAreFewer) {
  auto world = gps_world<TestFixture::kDim>({.poses = 400, .between = 2});
  std::set<std::size_t> wrong;
  const std::size_t first = world.log.edges().size();
  for (std::size_t f = 0; first + f < world.log.graph.pose_factors.size(); ++f) {
    if (f % 5 >= 2) continue;
    world.log.graph.pose_factors[first + f].measured.translation.setConstant(-4e6);
    wrong.insert(f);
  }
  EXPECT_EQ(this->found_in(world.log), wrong);
}

TYPED_TEST(FixInliers, AFixBeyondAllNumbersIsFound) {
  auto world = gps_world<TestFixture::kDim>();
  world.log.graph.pose_factors[world.log.edges().size() + 7].measured.translation[0] = 1e200;
  EXPECT_EQ(this->found_in(world.log), std::set<std::size_t>{7});
}

TYPED_TEST(FixInliers, FixesThatDetermineNoAlignmentAreKept) {
  auto world = gps_world<TestFixture::kDim>({.between = 1000});
  ASSERT_EQ(world.log.pose_priors().size(), 1U);
  EXPECT_TRUE(this->found_in(world.log).empty());
}

TYPED_TEST(FixInliers, FixesNoTwoOfWhichAgreeAreRefused) {
  auto world = gps_world<TestFixture::kDim>();
  const std::size_t first = world.log.edges().size();
  for (auto& fix : std::span(world.log.graph.pose_factors).subspan(first)) fix.measured.translation *= 1e3;
  EXPECT_THAT(testing::error_of(find_wrong_fixes(world.log, RobustOptions{})),
              ::testing::HasSubstr("too few fixes agree to hold the map; without --robust"));
}

TYPED_TEST(FixInliers, ALogWithoutThemKeepsTheOthersInOrder) {
  const auto world = gps_world<TestFixture::kDim>();
  const auto some = without_fixes(world.log, {{1, 0.0, 1.0}, {4, 0.0, 1.0}});
  ASSERT_EQ(some.pose_priors().size() + 2, world.log.pose_priors().size());
  EXPECT_EQ(some.pose_priors()[0].target, world.log.pose_priors()[0].target);
  EXPECT_EQ(some.pose_priors()[1].target, world.log.pose_priors()[2].target);
  EXPECT_EQ(some.pose_priors()[3].target, world.log.pose_priors()[5].target);
  EXPECT_EQ(some.edges().size(), world.log.edges().size());
}

}  // namespace
}  // namespace mapjoin::testing
