// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mapjoin/geometry/euler.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::numerical_jacobian;
using testing::Random;

TEST(Euler, TurnsAboutTheFixedAxesInTheOrderRollPitchYaw) {
  const double quarter = std::numbers::pi / 2.0;
  // The axis x: roll leaves it, pitch turns it down, yaw leaves it there. The axis y: roll turns it up, pitch forward, yaw
  // left.
  const Matrix<3> R = rotation_from_euler(quarter, quarter, quarter).matrix();
  EXPECT_LT((R.col(0) + Vector<3>::UnitZ()).norm(), 1e-15);
  EXPECT_LT((R.col(1) - Vector<3>::UnitY()).norm(), 1e-15);

  const Matrix<3> yawed = rotation_from_euler(0.0, 0.0, 0.3).matrix();
  EXPECT_NEAR(yawed(1, 0), std::sin(0.3), 1e-15);
  const Matrix<3> pitched = rotation_from_euler(0.0, 0.3, 0.0).matrix();
  EXPECT_NEAR(pitched(0, 2), std::sin(0.3), 1e-15);
  const Matrix<3> rolled = rotation_from_euler(0.3, 0.0, 0.0).matrix();
  EXPECT_NEAR(rolled(2, 1), std::sin(0.3), 1e-15);
}

TEST(Euler, AnglesComeBackFromTheRotation) {
  Random random;
  for (int i = 0; i < 20; ++i) {
    const Vector<3> angles = random.vector<3>(1.5);
    EXPECT_LT((euler_from_rotation(rotation_from_euler(angles[0], angles[1], angles[2])) - angles).norm(), 1e-12);
  }
}

TEST(Euler, JacobianEqualsCentralDifferences) {
  Random random;
  for (int i = 0; i < 20; ++i) {
    const Vector<3> a = random.vector<3>(1.5);
    const Rotation<3> R = rotation_from_euler(a[0], a[1], a[2]);
    const auto J = numerical_jacobian(
        [&](const auto& d) { return (R.inverse() * rotation_from_euler(a[0] + d[0], a[1] + d[1], a[2] + d[2])).log(); }, 3);
    EXPECT_TRUE(J_vector_euler(a[0], a[1], a[2]).isApprox(J, 1e-8)) << a.transpose();
  }
}

TEST(Euler, GiveTheRotationBackWhereItPointsStraightUpOrDown) {
  for (const double pitch : {0.5 * std::numbers::pi, -0.5 * std::numbers::pi, 1.5707}) {
    for (const double roll : {-3.0, -0.7, 0.0, 2.04}) {
      for (const double yaw : {-2.48, 0.0, 1.3}) {
        const Matrix<3> R = rotation_from_euler(roll, pitch, yaw).matrix();
        const Vector<3> angles = euler_from_rotation(rotation_from_euler(roll, pitch, yaw));
        EXPECT_LT((rotation_from_euler(angles[0], angles[1], angles[2]).matrix() - R).norm(), 1e-12) << roll << ' ' << yaw;
      }
    }
  }
}

}  // namespace
}  // namespace mapjoin
