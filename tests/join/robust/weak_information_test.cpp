// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <mapjoin/join/robust/weak_information.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// A drive along a bend, in some unit of length, whose odometry measures no motion to the side: closures over seven and over
/// ten steps do, the first `closed` poses only.
Log<2> bend(double units_per_metre, std::uint64_t closed) {
  const auto W = [&](double along, double aside, double turn) {
    const double share = 1.0 / (units_per_metre * units_per_metre);
    return PoseMatrix<2>(PoseVector<2>(share * along, share * aside, turn).asDiagonal());
  };
  const Pose<2> step{{units_per_metre, units_per_metre}, Rotation<2>(0.1)};
  std::vector<Pose<2>> poses{{}};
  while (poses.size() < 100) poses.push_back(compose(poses.back(), step));
  LogBuilder<2> builder("bend");
  for (std::uint64_t k = 1; k < poses.size(); ++k) {
    builder.add_pose_edge({0, k - 1}, {0, k}, {{units_per_metre, 0.0}, Rotation<2>(0.1)}, W(100.0, 0.0, 1e6));
  }
  for (const std::uint64_t steps : {7U, 10U}) {
    for (std::uint64_t k = 0; k + steps < closed; ++k) {
      builder.add_pose_edge({0, k}, {0, k + steps}, between(poses[k], poses[k + steps]), W(400.0, 400.0, 1e4));
    }
  }
  return std::move(builder).finish().value();
}

TEST(WeakInformation, IsAShareOfTheMedianOfTheEdgesThatMeasureARow) {
  const PoseVector<2> weak = weak_information(bend(1000.0, 100));
  EXPECT_NEAR(weak[0], kWeakShare * 4e-4, 1e-9 * kWeakShare);  // more closures than steps
  EXPECT_NEAR(weak[1], kWeakShare * 4e-4, 1e-9 * kWeakShare);
  EXPECT_NEAR(weak[2], kWeakShare * 1e4, 1e-9 * kWeakShare);
}

TEST(WeakInformation, OfWhatNoEdgeMeasuresIsThatOfTheWholeMap) {
  const Log<2> log = bend(1000.0, 0);
  const double extent = OdometryChain<2>(log).extent();
  EXPECT_NEAR(weak_information(log)[1] * extent * extent, 1.0, 1e-12);
}

TEST(WeakInformation, IsGivenOnlyToEdgesThatLackSome) {
  const PoseMatrix<2> whole = PoseVector<2>(4.0, 2.0, 1.0).asDiagonal();
  const PoseMatrix<2> position = PoseVector<2>(4.0, 2.0, 0.0).asDiagonal();
  const PoseVector<2> weak(1.0, 2.0, 3.0);
  PoseFactor<2> edge{0, 1, {}, whole};
  complete_weakly(edge, weak);
  EXPECT_EQ(edge.information, whole);
  edge.information = position;
  complete_weakly(edge, weak);
  const PoseVector<2> added = (edge.information - position).diagonal();
  EXPECT_LT((added - PoseVector<2>(4e-9, 2e-9, 3.0)).norm(), 1e-15);
}

TEST(WeakInformation, LeavesRightClosuresInLogsOfAnyUnit) {
  for (const double units : {1.0, 1000.0}) {
    EXPECT_TRUE(find_inliers(bend(units, 100), RobustOptions{}).value().rejected.empty()) << units;
  }
}

}  // namespace
}  // namespace mapjoin
