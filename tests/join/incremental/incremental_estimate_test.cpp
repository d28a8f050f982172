// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/incremental/incremental_estimate.hpp>

namespace mapjoin {
namespace {

/// A pose sees a feature ten metres ahead, and measures only how far ahead it is, which hardly tells of a small turn.
TEST(IncrementalEstimate, AStepThatWouldRaiseChi2IsNotTaken) {
  const Pose<2> start{Point<2>::Zero(), Rotation<2>(0.05)};
  const PoseVector<2> weights(1e6, 1e6, 1e-9);
  const LocalMap<2> position{kWorld, {0}, {}, {Pose<2>{}}, {}, weights.asDiagonal()};
  const LocalMap<2> sight{0, {}, {0}, {}, {Point<2>(5.0, 0.0)}, Vector<2>(1.0, 1e-9).asDiagonal()};
  IncrementalEstimate<2> estimate;
  const JoinedIndex pose = estimate.add_variable(true, start, false);
  const JoinedIndex feature = estimate.add_variable(false, {Point<2>(10.0, 0.0), {}}, true);
  estimate.add_factor({position, {kJoinedWorld, pose}});
  estimate.add_factor({sight, {pose, feature}});
  const double chi2 = estimate.chi2();
  const Settling settling = estimate.settle({});
  EXPECT_FALSE(settling.converged);
  EXPECT_EQ(local(estimate.variables()[pose].value, start).norm(), 0.0);
  EXPECT_NEAR(estimate.chi2(), chi2, 1e-9 * chi2);
}

}  // namespace
}  // namespace mapjoin
