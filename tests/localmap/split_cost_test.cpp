// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/localmap/split.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::small_world;

template <typename D>
class SplitCostTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr double kDof = kPoseDof<kDim>;
  /// Ten poses in a row, without noise: pose 2 k sees features 0 to k, the others see none.
  static Log<kDim> widening_corridor() {
    auto log = small_world<kDim>({.poses = 10, .features = 0, .closures = 0, .noise = 0.0}).log;
    for (std::uint64_t f = 0; f < 5; ++f) log.features.push_back({f});
    for (PoseIndex pose = 0; pose < 10; pose += 2) {
      for (FeatureIndex f = 0; f.value <= pose.value / 2; ++f) {
        log.graph.feature_factors.push_back({pose, f, Point<kDim>::Zero(), PointMatrix<kDim>::Identity()});
      }
    }
    return log;
  }
  /// The cost per step of joining and building a map of `steps` steps with `m` scalar variables in its border.
  static double of_a_map(double steps, double m) { return (joining(m) + building(steps, m)) / steps; }
  /// The cost per step of the widening corridor joined step by step.
  static double of_single_steps() {
    double cost = 4.0 * joining(2.0 * kDof);  // of steps from poses that see nothing
    for (const double features : {1.0, 2.0, 3.0, 4.0, 5.0}) cost += joining(2.0 * kDof + kDim * features);
    return cost / 9.0;
  }
  static double joining(double m) { return 4.0 * (30.0 * m * m + 0.4 * m * m * m); }
  static double building(double steps, double m) { return 5.0 * (2.0 * steps * kDof * m * m + 0.5 * m * m * m); }
};
TYPED_TEST_SUITE(SplitCostTest, testing::Dimensions);

TYPED_TEST(SplitCostTest, IsThatOfTheBorderWhereEachFeatureCountsOnce) {
  using T = TestFixture;
  const auto log = T::widening_corridor();
  const Table<PoseIndex, bool> nothing_kept(log.poses.size(), false);
  // The border of the one map of nine steps: its ends, and five features, which its poses see fifteen times.
  const double m = 2.0 * T::kDof + T::kDim * 5.0;
  EXPECT_NEAR(cost_per_step(log, nothing_kept, 9), T::of_a_map(9.0, m), 1e-9 * T::joining(m));
}

TYPED_TEST(SplitCostTest, CountsKeptPosesInTheBorder) {
  using T = TestFixture;
  const auto log = T::widening_corridor();
  Table<PoseIndex, bool> kept(log.poses.size(), false);
  kept[3] = kept[4] = true;
  const double m = 4.0 * T::kDof + T::kDim * 5.0;
  EXPECT_NEAR(cost_per_step(log, kept, 9), T::of_a_map(9.0, m), 1e-9 * T::joining(m));
}

TYPED_TEST(SplitCostTest, IsSummedOverSegmentsOfWhichEachCountsItsOwnFeatures) {
  using T = TestFixture;
  const auto log = T::widening_corridor();
  double expected = 0.0;
  for (const double features : {2.0, 3.0, 5.0}) {  // seen from poses 0 to 2, 3 to 5 and 6 to 9
    expected += T::of_a_map(3.0, 2.0 * T::kDof + T::kDim * features) / 3.0;
  }
  EXPECT_NEAR(cost_per_step(log, Table<PoseIndex, bool>(log.poses.size(), false), 3), expected, 1e-9 * expected);
}

TYPED_TEST(SplitCostTest, IsThatOfAMapAsLongAsHalfOfItsPosesGo) {
  using T = TestFixture;
  const auto log = T::widening_corridor();
  Table<PoseIndex, bool> kept(log.poses.size(), false);
  kept[1] = kept[2] = kept[3] = kept[4] = true;
  const double m = 6.0 * T::kDof + T::kDim * 5.0;
  EXPECT_NEAR(cost_per_step(log, kept, 9), T::of_a_map(9.0, m), 1e-9 * T::joining(m));
  kept[5] = true;
  EXPECT_NEAR(cost_per_step(log, kept, 9), T::of_single_steps(), 1e-9 * T::of_single_steps());
}

TYPED_TEST(SplitCostTest, OfARawSegmentIsThatOfItsSteps) {
  using T = TestFixture;
  const auto log = T::widening_corridor();
  const Table<PoseIndex, bool> all_kept(log.poses.size(), true);
  for (const int poses_per_map : {1, 3, 9}) {
    EXPECT_NEAR(cost_per_step(log, all_kept, poses_per_map), T::of_single_steps(), 1e-9 * T::of_single_steps());
  }
}

TYPED_TEST(SplitCostTest, IsInfiniteWhereTheLogIsShorter) {
  const auto log = TestFixture::widening_corridor();
  EXPECT_EQ(cost_per_step(log, Table<PoseIndex, bool>(log.poses.size(), false), 10), std::numeric_limits<double>::infinity());
}

TYPED_TEST(SplitCostTest, ChoosesTheCheapestOfItsCandidates) {
  const auto log = small_world<TestFixture::kDim>({.poses = 120}).log;
  const Table<PoseIndex, bool> nothing_kept(log.poses.size(), false);
  for (const double fewest : {0.0, 6.0, 31.0}) {
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (const int n : {1, 2, 3, 5, 7, 10, 15, 20, 30, 45, 70, 100}) {
      const double cost = cost_per_step(log, nothing_kept, n);
      if (n < fewest || cost >= least) continue;
      best = n;
      least = cost;
    }
    EXPECT_EQ(cheapest_poses_per_map(log, nothing_kept, fewest), best) << fewest;
  }
  EXPECT_EQ(cheapest_poses_per_map(log, nothing_kept, 101.0), 100);
}

TYPED_TEST(SplitCostTest, OneStepIsTakenWhereLongerSegmentsWouldBeNoMaps) {
  constexpr int kDim = TestFixture::kDim;
  auto log = small_world<kDim>({.poses = 190, .features = 0, .closures = 0, .noise = 0.0}).log;
  Table<PoseIndex, bool> kept(log.poses.size(), true);
  kept[21] = kept[22] = kept[23] = false;  // one of many windows becomes a map, which saves less than a hundredth
  EXPECT_EQ(cheapest_poses_per_map(log, kept, 0.0), 1);
}

}  // namespace
}  // namespace mapjoin
