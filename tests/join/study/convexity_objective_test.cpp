// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/study/convexity_objective.hpp>
#include <mapjoin/join/study/convexity_states.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/measure/curvature.hpp>
#include <tests/join/study/posed_world.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>

namespace mapjoin {
namespace {

using testing::PosedWorld;

template <typename D>
class UnwrappedObjectiveTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  Log<kDim> log_ = testing::small_world<kDim>({.poses = 30, .features = 12, .reversed_odometry = true}).log;
};
TYPED_TEST_SUITE(UnwrappedObjectiveTest, testing::Dimensions);

TYPED_TEST(UnwrappedObjectiveTest, IsChi2OfTheLogNearTheReference) {
  PosedWorld<TestFixture::kDim> world(this->log_);
  const UnwrappedObjective<TestFixture::kDim> objective(world.system(), world.state());
  for (const double radius : {0.0, 0.1, 0.5}) {
    const auto state = world.moved_by(radius);
    const double chi2 = log_chi2(this->log_, state).total();
    EXPECT_NEAR(objective(state), chi2, 1e-12 * chi2);
  }
}

TYPED_TEST(UnwrappedObjectiveTest, IsChi2OfTheJoinNearTheReference) {
  PosedWorld<TestFixture::kDim> world(this->log_, 6.0);
  ASSERT_GT(world.system().maps().size(), 0u);
  const UnwrappedObjective<TestFixture::kDim> objective(world.system(), world.state());
  PartialMap<TestFixture::kDim> partial = world.composed;
  partial.state = world.moved_by(0.2);
  EXPECT_NEAR(objective(partial.state), partial_map_chi2(partial), 1e-12 * partial_map_chi2(partial));
}

TYPED_TEST(UnwrappedObjectiveTest, IsQuadraticWhereAllRelationsAreInTheState) {
  constexpr int kDim = TestFixture::kDim;
  PosedWorld<kDim> world(testing::tree_world<kDim>(true));
  const UnwrappedObjective<kDim> objective(world.system(), world.state());
  const RelativeCoordinates<kDim> relative(world.system(), world.state());
  testing::Random random;
  const auto draw = [&] {
    return Eigen::VectorXd(Eigen::VectorXd::NullaryExpr(relative.size(), [&] { return random.uniform(-1.7, 1.7); }));
  };
  const Eigen::VectorXd x = draw();
  const Eigen::VectorXd y = draw();
  const auto F = [&](double lambda) { return objective(relative.composed(lambda * x + (1.0 - lambda) * y)); };
  const double second_difference = F(1.0) - 2.0 * F(0.5) + F(0.0);
  EXPECT_GT(second_difference, 0.0);
  for (const double lambda : {0.2, 0.7}) {
    const double parabola = F(0.0) + lambda * (F(1.0) - F(0.0)) - 2.0 * lambda * (1.0 - lambda) * second_difference;
    EXPECT_NEAR(F(lambda), parabola, 1e-11 * F(0.0));
  }
}

/// Headings count as numbers: the whole turns that are added to a measured one are chosen at the reference, and the same at
/// every state.
TEST(UnwrappedObjective, TakesHeadingDifferencesAsTheyAre) {
  PosedWorld<2> world(testing::small_world<2>({.poses = 60, .features = 10, .closures = 6}).log);
  const Values<2> reference = world.state();
  const UnwrappedObjective<2> objective(world.system(), reference);
  const Values<2> state = world.moved_by(6.0);
  double sum = 0.0;
  int beyond_a_half_turn = 0;
  for (const auto& [o, base, target] : world.system().pose_factors()) {
    Eigen::VectorXd r = testing::plain_residual<2>(o->measured, state.pose(base), state.pose(target));
    const double at_reference = testing::plain_residual<2>(o->measured, reference.pose(base), reference.pose(target))[2];
    const auto heading = [](const Values<2>& s, PoseIndex pose) { return s.pose(pose).rotation.angle(); };
    // The residual at the reference, less the change of the difference of headings since.
    r[2] = at_reference - (heading(state, target) - heading(state, base)) +
           (heading(reference, target) - heading(reference, base));
    beyond_a_half_turn += std::abs(r[2]) > std::numbers::pi;
    sum += r.dot(o->information * r);
  }
  for (const auto& [o, base, target] : world.system().feature_factors()) {
    const Eigen::VectorXd r = testing::plain_residual<2>(o->measured, state.pose(base), state.features[target]);
    sum += r.dot(o->information * r);
  }
  EXPECT_GT(beyond_a_half_turn, 10);
  EXPECT_NEAR(objective(state), sum, 1e-11 * sum);
}

}  // namespace
}  // namespace mapjoin
