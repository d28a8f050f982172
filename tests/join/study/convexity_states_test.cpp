// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/study/convexity_states.hpp>
#include <mapjoin/model/linearise.hpp>
#include <tests/join/study/posed_world.hpp>
#include <tests/support/dimensions.hpp>

namespace mapjoin {
namespace {

using testing::largest_difference;
using testing::PosedWorld;

template <typename D>
class ConvexityStatesTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  PosedWorld<kDim> world_{testing::small_world<kDim>({.poses = 30, .features = 12, .reversed_odometry = true}).log};
};
TYPED_TEST_SUITE(ConvexityStatesTest, testing::Dimensions);

TYPED_TEST(ConvexityStatesTest, ALineHasItsEnds) {
  const auto X = this->world_.moved_by(1.0, 1);
  const auto Y = this->world_.moved_by(1.0, 2);
  EXPECT_LT(largest_difference(on_line(X, Y, 1.0), X), 1e-12);
  EXPECT_LT(largest_difference(on_line(X, Y, 0.0), Y), 1e-12);
}

TYPED_TEST(ConvexityStatesTest, ALineGoesOnAtOneSpeed) {
  const auto X = this->world_.moved_by(1.0, 1);
  const auto Y = this->world_.moved_by(1.0, 2);
  const auto middle = on_line(X, Y, 0.5);
  for (const PoseIndex p : indices(X.poses)) {
    const auto half = local(Y.poses[p], middle.poses[p]);
    EXPECT_LT((local(Y.poses[p], X.poses[p]) - 2.0 * half).norm(), 1e-12);
  }
  EXPECT_LT((middle.features[3] - 0.5 * (X.features[3] + Y.features[3])).norm(), 1e-12);
}

TYPED_TEST(ConvexityStatesTest, RelativeCoordinatesAreThoseOfTheState) {
  const RelativeCoordinates<TestFixture::kDim> relative(this->world_.system(), this->world_.state());
  const auto X = this->world_.moved_by(2.0);
  const Eigen::VectorXd x = relative.of(X);
  EXPECT_EQ(x.size(), this->world_.system().equations().size());
  EXPECT_LT(largest_difference(relative.composed(x), X), 1e-10);
}

TYPED_TEST(ConvexityStatesTest, RelativeCoordinatesOfTheComposedStartAreZero) {
  const RelativeCoordinates<TestFixture::kDim> relative(this->world_.system(), this->world_.state());
  EXPECT_LT(relative.of(this->world_.state()).norm(), 1e-10);
}

TYPED_TEST(ConvexityStatesTest, RelativeCoordinatesAreTheResidualsOfTheTree) {
  constexpr int kDim = TestFixture::kDim;
  const RelativeCoordinates<kDim> relative(this->world_.system(), this->world_.state());
  const auto X = this->world_.moved_by(0.3);
  const Eigen::VectorXd x = relative.of(X);
  for (std::size_t e = 0; e < relative.tree().poses.size(); ++e) {
    const auto& o = this->world_.system().pose_factors()[relative.tree().poses[e].observation->factor];
    const PoseVector<kDim> r = residual<kDim>(o.observation->measured, X.pose(o.base), X.pose(o.target));
    const PoseVector<kDim> own = x.template segment<kPoseDof<kDim>>(relative.pose_entry(e));
    EXPECT_LT((own.template tail<kRotationDof<kDim>>() + r.template tail<kRotationDof<kDim>>()).norm(), 1e-10);
    EXPECT_LT((own.template head<kDim>() + r.template head<kDim>()).norm(), 1e-10);
  }
}

TEST(UnwrappedNear, PutsHeadingsWithinHalfATurn) {
  Values<2> reference{{Pose<2>{{0.0, 0.0}, Rotation<2>(20.0)}}, {}};
  Values<2> state{{Pose<2>{{1.0, 2.0}, Rotation<2>(1.0)}}, {}};
  const Values<2> unwrapped = unwrapped_near(state, reference);
  EXPECT_NEAR(unwrapped.poses[0].rotation.angle(), 1.0 + 6.0 * std::numbers::pi, 1e-12);
  EXPECT_EQ(unwrapped.poses[0].translation, state.poses[0].translation);
}

TEST(OnLine, TakesHeadingsForNumbers) {
  const Values<2> X{{Pose<2>{{0.0, 0.0}, Rotation<2>(-9.0)}}, {}};
  const Values<2> Y{{Pose<2>{{0.0, 0.0}, Rotation<2>(7.0)}}, {}};
  EXPECT_NEAR(on_line(X, Y, 0.25).poses[0].rotation.angle(), 3.0, 1e-12);
}

}  // namespace
}  // namespace mapjoin
