// SPDX-License-Identifier: BSD-3-Clause
// Priors of the end of a lever on a pose, such as the antenna of a satellite receiver.
#include <gtest/gtest.h>

#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/model/cost.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/random.hpp>

namespace mapjoin::testing {
namespace {

template <typename D>
class Lever : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;

  /// The numbers of coordinates of the rotation that a prior may measure: in space, one is the yaw.
  static constexpr int kRotations[] = {0, 1, kRotationDof<kDim>};

  /// A prior of the position, and of the last `rotations` coordinates of the rotation, with a lever.
  PoseFactor<kDim> prior(int rotations) {
    PoseFactor<kDim> prior{kWorld, 0, retract(pose, PoseVector<kDim>(random.vector<kDof>(0.3))), random.information<kDof>()};
    const int unmeasured = kRotationDof<kDim> - rotations;
    prior.information.middleRows(kDim, unmeasured).setZero();
    prior.information.middleCols(kDim, unmeasured).setZero();
    prior.lever = random.vector<kDim>(4.0);
    return prior;
  }
  /// The H and g of the factor at the pose.
  std::pair<PoseMatrix<kDim>, PoseVector<kDim>> normal_equations(const PoseFactor<kDim>& factor) const {
    Sink sink;
    accumulate(linearise(factor, Pose<kDim>{}, pose), sink);
    return {sink.H, sink.g};
  }

  struct Sink {
    PoseMatrix<kDim> H;
    PoseVector<kDim> g;
    void hessian(int i, int j, const PoseMatrix<kDim>& block) {
      if (i == 1 && j == 1) H = block;
    }
    void rhs(int i, const PoseVector<kDim>& block) {
      if (i == 1) g = block;
    }
  };

  Random random{3};
  Pose<kDim> pose = random.pose<kDim>(10.0, 2.0);
};
TYPED_TEST_SUITE(Lever, Dimensions);

TYPED_TEST(Lever, MeasuresItsEnd) {
  constexpr int kDim = TestFixture::kDim;
  PoseFactor<kDim> prior = this->prior(0);
  prior.measured.translation = this->pose.translation + this->pose.rotation.matrix() * prior.lever;
  EXPECT_NEAR(cost(prior, Pose<kDim>{}, this->pose), 0.0, 1e-20);
  prior.lever.setZero();
  EXPECT_GT(cost(prior, Pose<kDim>{}, this->pose), 0.0);
}

TYPED_TEST(Lever, JacobianIsThatOfCentralDifferences) {
  constexpr int kDim = TestFixture::kDim;
  for (const int rotations : TestFixture::kRotations) {
    const PoseFactor<kDim> prior = this->prior(rotations);
    const auto predicted = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
      const Pose<kDim> moved = retract(this->pose, PoseVector<kDim>(step));
      return -residual<kDim>(prior.measured, Pose<kDim>{}, measured_part(prior, moved));
    };
    const auto linear = linearise(prior, Pose<kDim>{}, this->pose);
    const Eigen::MatrixXd J = numerical_jacobian(predicted, kPoseDof<kDim>);
    EXPECT_LT((linear.target.J_target - J).norm(), 1e-7 * J.norm());
  }
}

TYPED_TEST(Lever, TakenOffAtAValueLeavesCostGradientAndInformationThere) {
  constexpr int kDim = TestFixture::kDim;
  for (const int rotations : TestFixture::kRotations) {
    const PoseFactor<kDim> prior = this->prior(rotations);
    const PoseFactor<kDim> plain = without_lever(prior, this->pose);
    EXPECT_TRUE(plain.lever.isZero(0.0));
    const auto [H, g] = this->normal_equations(prior);
    const auto [H_plain, g_plain] = this->normal_equations(plain);
    const double before = cost(prior, Pose<kDim>{}, this->pose);
    EXPECT_NEAR(cost(plain, Pose<kDim>{}, this->pose), before, 1e-9 * before) << rotations;
    EXPECT_LT((H_plain - H).norm(), 1e-10 * H.norm()) << rotations;
    EXPECT_LT((g_plain - g).norm(), 1e-10 * g.norm()) << rotations;
  }
}

}  // namespace
}  // namespace mapjoin::testing
