// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/geometry/rotation.hpp>
#include <numbers>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

/// The second derivatives of uᵀ Log(Exp(δ) Exp(v)) at δ = 0, by central differences.
Matrix<3> log_curvature_by_differences(const RotationVector<3>& v, const RotationVector<3>& u) {
  constexpr double kStep = 1e-4;
  const auto gradient = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    const auto value = [&](const Eigen::VectorXd& step) {
      const auto turned = Rotation<3>::exp(RotationVector<3>(at + step)) * Rotation<3>::exp(v);
      return Eigen::VectorXd::Constant(1, u.dot(turned.log())).eval();
    };
    return testing::numerical_jacobian(value, 3, kStep).transpose();
  };
  return testing::numerical_jacobian(gradient, 3, kStep);
}

TEST(RotationInSpace, LogCurvatureIsThatOfCentralDifferences) {
  testing::Random random;
  const double threshold = std::sqrt(1e-3);  // below which log_curvature() takes a series
  for (const double angle : {0.0, 1e-4, 0.999 * threshold, 1.001 * threshold, 0.3, 1.5, 3.0, std::numbers::pi - 1e-2}) {
    for (int k = 0; k < 5; ++k) {
      const RotationVector<3> v = angle * random.vector<3>().normalized();
      const RotationVector<3> u = random.vector<3>();
      const Matrix<3> expected = log_curvature_by_differences(v, u);
      EXPECT_LT((log_curvature(v, u) - expected).norm(), 1e-6 * (1.0 + expected.norm())) << angle;
    }
  }
}

TEST(RotationInSpace, LogCurvatureGoesOnSmoothlyWhereItsSeriesEnds) {
  testing::Random random;
  const double threshold = std::sqrt(1e-3);
  for (int k = 0; k < 5; ++k) {
    const RotationVector<3> axis = random.vector<3>().normalized();
    const RotationVector<3> u = random.vector<3>();
    const Matrix<3> below = log_curvature(threshold * (1.0 - 1e-9) * axis, u);
    EXPECT_LT((below - log_curvature(threshold * (1.0 + 1e-9) * axis, u)).norm(), 1e-10);
  }
}

}  // namespace
}  // namespace mapjoin
