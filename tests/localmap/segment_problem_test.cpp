// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/localmap/segment_problem.hpp>
#include <tests/support/curvature_check.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class SegmentProblemTest : public ::testing::Test {};
TYPED_TEST_SUITE(SegmentProblemTest, testing::Dimensions);

TYPED_TEST(SegmentProblemTest, CurvatureMakesItsHessianThatOfFullNewton) {
  constexpr int kDim = TypeParam::value;
  const auto world = testing::small_world<kDim>({.poses = 12, .features = 8});
  const Split parts = split(world.log, {SplitRule::kPoses, 11.0});
  const SegmentView<kDim> view = segment_view(world.log, parts, parts.segments.front());
  testing::Random random(5);
  Values<kDim> start = composed_start(view);
  for (auto& pose : start.poses) pose = retract<kDim>(pose, random.vector<kPoseDof<kDim>>(0.3));
  for (const bool kept : {true, false}) {
    SegmentProblem<kDim> problem(view, {kept, Table<FeatureIndex, bool>(view.features.size(), true)}, start);
    testing::expect_full_newton(problem);
  }
}

}  // namespace
}  // namespace mapjoin
