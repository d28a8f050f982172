// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mapjoin/geometry/pose.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::numerical_jacobian;
using testing::Random;

template <typename D>
class PoseTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  Random random;
};
using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(PoseTest, Dimensions);

template <int Dim>
double distance(const Pose<Dim>& a, const Pose<Dim>& b) {
  return local(a, b).norm();
}

TYPED_TEST(PoseTest, LocalUndoesRetract) {
  constexpr int kDim = TestFixture::kDim;
  for (int i = 0; i < 50; ++i) {
    const auto pose = this->random.template pose<kDim>();
    const PoseVector<kDim> delta = this->random.template vector<kPoseDof<kDim>>(1.7);
    EXPECT_LT((local(pose, retract(pose, delta)) - delta).norm(), 1e-12);
  }
}

TYPED_TEST(PoseTest, BetweenUndoesComposeAndInverseIsBetweenTheOrigin) {
  constexpr int kDim = TestFixture::kDim;
  for (int i = 0; i < 50; ++i) {
    const auto a = this->random.template pose<kDim>();
    const auto b = this->random.template pose<kDim>();
    EXPECT_LT(distance(between(a, compose(a, b)), b), 1e-12);
    EXPECT_LT(distance(compose(a, inverse(a)), Pose<kDim>{}), 1e-12);
    const Point<kDim> p = this->random.template vector<kDim>(3.0);
    EXPECT_LT((transform_into(a, transform(a, p)) - p).norm(), 1e-12);
    EXPECT_LT((transform(compose(a, b), p) - transform(a, transform(b, p))).norm(), 1e-12);
  }
}

TYPED_TEST(PoseTest, JacobiansEqualCentralDifferences) {
  constexpr int kDim = TestFixture::kDim;
  constexpr int kDof = kPoseDof<kDim>;
  for (int i = 0; i < 20; ++i) {
    const auto a = this->random.template pose<kDim>();
    const auto b = this->random.template pose<kDim>();
    const Point<kDim> p = this->random.template vector<kDim>(3.0);
    PoseMatrix<kDim> J_a, J_b;

    const auto ab = compose(a, b, &J_a, &J_b);
    EXPECT_TRUE(J_a.isApprox(
        numerical_jacobian([&](const auto& d) { return local(ab, compose(retract<kDim>(a, d), b)); }, kDof), 1e-8));
    EXPECT_TRUE(J_b.isApprox(
        numerical_jacobian([&](const auto& d) { return local(ab, compose(a, retract<kDim>(b, d))); }, kDof), 1e-8));

    const auto a_b = between(a, b, &J_a, &J_b);
    EXPECT_TRUE(J_a.isApprox(
        numerical_jacobian([&](const auto& d) { return local(a_b, between(retract<kDim>(a, d), b)); }, kDof), 1e-8));
    EXPECT_TRUE(J_b.isApprox(
        numerical_jacobian([&](const auto& d) { return local(a_b, between(a, retract<kDim>(b, d))); }, kDof), 1e-8));

    const auto a_inverse = inverse(a, &J_a);
    EXPECT_TRUE(J_a.isApprox(
        numerical_jacobian([&](const auto& d) { return local(a_inverse, inverse(retract<kDim>(a, d))); }, kDof), 1e-8));

    PointPoseMatrix<kDim> J_pose;
    PointMatrix<kDim> J_point;
    transform(a, p, &J_pose, &J_point);
    EXPECT_TRUE(
        J_pose.isApprox(numerical_jacobian([&](const auto& d) { return transform(retract<kDim>(a, d), p); }, kDof), 1e-8));
    EXPECT_TRUE(J_point.isApprox(numerical_jacobian([&](const auto& d) { return transform<kDim>(a, p + d); }, kDim), 1e-8));
    transform_into(a, p, &J_pose, &J_point);
    EXPECT_TRUE(
        J_pose.isApprox(numerical_jacobian([&](const auto& d) { return transform_into(retract<kDim>(a, d), p); }, kDof), 1e-8));
    EXPECT_TRUE(
        J_point.isApprox(numerical_jacobian([&](const auto& d) { return transform_into<kDim>(a, p + d); }, kDim), 1e-8));
  }
}

TEST(RotationTest, ExpAndLogKeepTheirDigitsNearZeroAndNearPi) {
  for (const double angle : {0.0, 1e-12, 1e-8, 9e-5, 1.1e-4, 1e-3, 0.5, 3.0, std::numbers::pi - 1e-9}) {
    const Vector<3> v = angle * Vector<3>(2.0, -1.0, 2.0) / 3.0;
    EXPECT_LT((Rotation<3>::exp(v).log() - v).norm(), 1e-14 + 1e-12 * angle) << angle;
  }
}

TEST(RotationTest, RightJacobianInverseEqualsCentralDifferences) {
  Random random;
  for (const double radius : {1e-5, 1e-2, 1.5}) {
    const Vector<3> v = random.vector<3>(radius);
    const auto J = numerical_jacobian([&](const auto& d) { return (Rotation<3>::exp(v) * Rotation<3>::exp(d)).log(); }, 3);
    EXPECT_TRUE(right_jacobian_inverse(v).isApprox(J, 1e-8)) << radius;
  }
}

TEST(RotationTest, HeadingsWrapToHalfATurnEitherWay) {
  EXPECT_NEAR(wrap_angle(std::numbers::pi + 0.1), -std::numbers::pi + 0.1, 1e-15);
  EXPECT_NEAR(wrap_angle(-7.0 * std::numbers::pi + 0.25), -std::numbers::pi + 0.25, 1e-14);
  EXPECT_DOUBLE_EQ(wrap_angle(1.25), 1.25);
}

TEST(RotationTest, WithoutTurnsIsTheSameWithOneHeadingOfAll) {
  for (const double turns : {-2.0, 0.0, 1.0}) {
    const Rotation<2> turned(2.5 + 2.0 * turns * std::numbers::pi);
    EXPECT_NEAR(turned.without_turns().angle(), 2.5, 1e-14);
    EXPECT_EQ(turned.without_turns().matrix(), turned.matrix());
  }
  EXPECT_EQ(Rotation<2>(-std::numbers::pi).without_turns().angle(), std::numbers::pi);
}

}  // namespace
}  // namespace mapjoin
