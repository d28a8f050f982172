// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mapjoin/io/g2o/fields.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

/// The paper's residual X̂ - H(X) for the true relative pose `relative`.
template <int Dim>
PoseVector<Dim> paper_residual(const Pose<Dim>& measured, const Pose<Dim>& relative) {
  PoseVector<Dim> r;
  r << measured.translation - relative.translation, (relative.rotation.inverse() * measured.rotation).log();
  return r;
}

/// The error of g2o, Z⁻¹ X_b⁻¹ X_t, with a rotation vector or, in space, the vector part of the quaternion.
template <int Dim>
PoseVector<Dim> g2o_error(const Pose<Dim>& measured, const Pose<Dim>& relative, RotationInformation rotation) {
  const Pose<Dim> E = compose(inverse(measured), relative);
  PoseVector<Dim> e;
  e << E.translation, E.rotation.log();
  if constexpr (Dim == 3) {
    if (rotation == RotationInformation::kQuaternion) {
      const auto q = E.rotation.quaternion();
      e.template tail<3>() = q.w() < 0.0 ? Vector<3>(-q.vec()) : Vector<3>(q.vec());
    }
  }
  return e;
}

TEST(G2oPose, IsOfUnitLengthAndKeepsItsBitsWhereItIsToRounding) {
  const auto rotation = [](const std::string& quaternion) {
    const std::string line = "1 2 3 " + quaternion + "\n";
    TextScanner text("some.g2o", line);
    text.next_line();
    return read_g2o_pose<3>(text).rotation.quaternion();
  };
  EXPECT_NEAR(rotation("0 0 0.6 0.8003").norm(), 1.0, 1e-15);
  const Eigen::Quaterniond nearly(0.8, 0.0, 0.0, 0.6 + 2e-16);
  EXPECT_EQ(rotation("0 0 0.6000000000000002 0.8").coeffs(), nearly.coeffs());
}

TEST(G2oPose, IsRefusedWhereItsQuaternionIsFarFromUnitLength) {
  for (const auto& [quaternion, is_taken] : {std::pair{"0 0 0 0.4", false}, {"0 0 0 0.6", true}, {"0 0 0 2.1", false}}) {
    const std::string line = std::string("1 2 3 ") + quaternion + "\n";
    TextScanner text("some.g2o", line);
    text.next_line();
    read_g2o_pose<3>(text);
    EXPECT_EQ(text.finish_line().has_value(), is_taken) << quaternion;
  }
}

template <typename D>
class G2oInformationTest : public ::testing::Test {
 protected:
  testing::Random random;
};
TYPED_TEST_SUITE(G2oInformationTest, testing::Dimensions);

TYPED_TEST(G2oInformationTest, TakenInG2osErrorTheChi2IsG2os) {
  constexpr int kDim = TypeParam::value;
  const ReadOptions options{.pose_error = PoseError::kG2o};
  for (int i = 0; i < 20; ++i) {
    const auto measured = this->random.template pose<kDim>();
    const auto relative = this->random.template pose<kDim>(5.0, 0.5);
    const auto W = this->random.template information<kPoseDof<kDim>>();
    const auto turned = from_g2o<kDim>(W, measured, options);
    const auto r = paper_residual(measured, relative);
    const auto e = g2o_error(measured, relative, RotationInformation::kVector);
    EXPECT_NEAR(r.dot(turned * r), e.dot(W * e), 1e-10 * e.dot(W * e));
    EXPECT_EQ(turned, turned.transpose());
  }
}

TYPED_TEST(G2oInformationTest, TakenAsThePapersTheInformationStaysAsItIs) {
  constexpr int kDim = TypeParam::value;
  const auto W = this->random.template information<kPoseDof<kDim>>();
  EXPECT_EQ(from_g2o<kDim>(W, this->random.template pose<kDim>(), {}), W);
}

TYPED_TEST(G2oInformationTest, OfAQuaternionTheChi2IsG2osToFirstOrder) {
  constexpr int kDim = TypeParam::value;
  const ReadOptions options{.pose_error = PoseError::kG2o, .rotation_information = RotationInformation::kQuaternion};
  const auto measured = this->random.template pose<kDim>();
  const auto W = this->random.template information<kPoseDof<kDim>>();
  const auto relative = retract(measured, 1e-4 * this->random.template vector<kPoseDof<kDim>>());
  const auto r = paper_residual(measured, relative);
  const auto e = g2o_error(measured, relative, RotationInformation::kQuaternion);
  EXPECT_NEAR(r.dot(from_g2o<kDim>(W, measured, options) * r), e.dot(W * e), 1e-8 * e.dot(W * e));
}

}  // namespace
}  // namespace mapjoin
