// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <tests/join/study/posed_world.hpp>
#include <tests/support/curvature_check.hpp>
#include <tests/support/dimensions.hpp>

namespace mapjoin {
namespace {

template <typename D>
class JoiningSystemTest : public ::testing::Test {};
TYPED_TEST_SUITE(JoiningSystemTest, testing::Dimensions);

TYPED_TEST(JoiningSystemTest, CurvatureMakesItsHessianThatOfFullNewton) {
  for (const double poses_per_map : {1.0, 5.0}) {
    testing::PosedWorld<TypeParam::value> world(testing::small_world<TypeParam::value>({.poses = 20, .features = 8}).log,
                                                poses_per_map);
    world.problem.estimate() = world.moved_by(0.3);
    testing::expect_full_newton(world.problem);
  }
}

}  // namespace
}  // namespace mapjoin
