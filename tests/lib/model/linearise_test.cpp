// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/model/linearise.hpp>
#include <numbers>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::numerical_jacobian;
using testing::plain_residual;
using testing::Random;

template <typename D>
class LineariseTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;
  /// A rotation by `angle` about a random axis.
  Rotation<kDim> turn(double angle) {
    return Rotation<kDim>::exp(angle * this->random.template vector<kRotationDof<kDim>>().normalized());
  }
  /// The pose of `target` in the frame of `base`, with a random error of its translation and one of `angle` of its rotation.
  Pose<kDim> measured(const Pose<kDim>& base, const Pose<kDim>& target, double angle) {
    const Pose<kDim> base_target = between(base, target);
    return {base_target.translation + random.vector<kDim>(), base_target.rotation * turn(angle)};
  }
  /// Expects the Jacobians ∂H/∂δ of the residual X̂ - H to be central differences.
  template <typename Measured, typename Target>
  void expect_jacobians(const Measured& measured, const Pose<kDim>& base, const Target& target, double tolerance) {
    const auto linear = linearise<kDim>(measured, base, target);
    EXPECT_LT((linear.residual - plain_residual<kDim>(measured, base, target)).norm(), 1e-9);
    const Eigen::VectorXd r = residual<kDim>(measured, base, target);
    EXPECT_EQ((linear.residual - r).norm(), 0.0);
    const Eigen::MatrixXd of_base = numerical_jacobian(
        [&](const Eigen::VectorXd& step) {
          return Eigen::VectorXd(-residual<kDim>(measured, retract<kDim>(base, PoseVector<kDim>(step)), target));
        },
        kDof);
    EXPECT_LT((linear.J_base - of_base).norm(), tolerance);
    const Eigen::MatrixXd of_target = numerical_jacobian(
        [&](const Eigen::VectorXd& step) { return Eigen::VectorXd(-residual<kDim>(measured, base, moved_by(target, step))); },
        linear.residual.size());
    EXPECT_LT((linear.J_target - of_target).norm(), tolerance);
  }
  static Pose<kDim> moved_by(const Pose<kDim>& pose, const Eigen::VectorXd& step) {
    return retract<kDim>(pose, PoseVector<kDim>(step));
  }
  static Point<kDim> moved_by(const Point<kDim>& point, const Eigen::VectorXd& step) { return point + step; }

  Random random;
};
TYPED_TEST_SUITE(LineariseTest, testing::Dimensions);

TYPED_TEST(LineariseTest, JacobiansOfAPoseTargetHoldForResidualsSmallAndLarge) {
  constexpr int kDim = TestFixture::kDim;
  for (const double angle : {0.0, 1e-9, 1e-5, 1e-3, 0.1, 1.0, 2.0, 3.0, 3.1}) {
    for (int k = 0; k < 5; ++k) {
      const Pose<kDim> base = this->random.template pose<kDim>();
      const Pose<kDim> target = this->random.template pose<kDim>();
      SCOPED_TRACE(angle);
      this->expect_jacobians(this->measured(base, target, angle), base, target, 1e-7);
    }
  }
}

TYPED_TEST(LineariseTest, JacobiansOfAPointTargetHold) {
  constexpr int kDim = TestFixture::kDim;
  for (int k = 0; k < 20; ++k) {
    const Point<kDim> measured = this->random.template vector<kDim>(50.0);
    const Pose<kDim> base = this->random.template pose<kDim>();
    this->expect_jacobians(measured, base, Point<kDim>(this->random.template vector<kDim>(50.0)), 1e-7);
  }
}

TYPED_TEST(LineariseTest, TheResidualVanishesAtWhatWasMeasured) {
  constexpr int kDim = TestFixture::kDim;
  const Pose<kDim> base = this->random.template pose<kDim>();
  const Pose<kDim> target = this->random.template pose<kDim>();
  const Point<kDim> feature = this->random.template vector<kDim>();
  EXPECT_LT((residual<kDim>(between(base, target), base, target).norm()), 1e-14);
  EXPECT_LT((residual<kDim>(transform_into(base, feature), base, feature).norm()), 1e-14);
}

TEST(LineariseTest, AHeadingResidualIsTheShortWayRound) {
  const Pose<2> measured{{1.0, 0.0}, Rotation<2>(3.0)};
  const Pose<2> target{{1.0, 0.0}, Rotation<2>(-3.0 + 8.0 * std::numbers::pi)};
  EXPECT_NEAR(residual<2>(measured, Pose<2>{}, target)[2], 6.0 - 2.0 * std::numbers::pi, 1e-12);
}

}  // namespace
}  // namespace mapjoin
