// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <mapjoin/measure/observation_curvature.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

/// By central differences of the value.
Matrix<3> numerical_hessian(const ObservationTerm& term, const Vector<3>& at) {
  constexpr double kStep = 1e-3;
  const auto value = [&](const Vector<3>& x) { return term.value(x[0], x.tail<2>()); };
  Matrix<3> H;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vector<3> a = kStep * Vector<3>::Unit(i);
      const Vector<3> b = kStep * Vector<3>::Unit(j);
      H(i, j) = (value(at + a + b) - value(at + a - b) - value(at - a + b) + value(at - a - b)) / (4.0 * kStep * kStep);
    }
  }
  return H;
}

class ObservationCurvature : public ::testing::TestWithParam<double> {
 protected:
  testing::Random random_{7};
};

TEST_P(ObservationCurvature, HessianIsThatOfTheValue) {
  for (int k = 0; k < 50; ++k) {
    const ObservationTerm term{random_.vector<2>(3.0), GetParam()};
    const Vector<3> at = random_.vector<3>(3.0);
    EXPECT_LT((term.hessian(at[0], at.tail<2>()) - numerical_hessian(term, at)).cwiseAbs().maxCoeff(), 1e-4);
  }
}

TEST_P(ObservationCurvature, IsConvexWhereNoEigenvalueIsNegative) {
  int convex = 0;
  int other = 0;
  for (int k = 0; k < 2000; ++k) {
    const ObservationTerm term{random_.vector<2>(3.0), GetParam()};
    const Vector<3> at = random_.vector<3>(4.0);
    const double least = Eigen::SelfAdjointEigenSolver<Matrix<3>>(numerical_hessian(term, at)).eigenvalues()[0];
    if (std::abs(least) < 1e-3) continue;  // on the border, to the differences' accuracy
    EXPECT_EQ(term.is_convex_at(at[0], at.tail<2>()), least > 0.0) << at.transpose();
    ++(least > 0.0 ? convex : other);
  }
  EXPECT_GT(convex, 100);
  EXPECT_GT(other, 100);
}

INSTANTIATE_TEST_SUITE_P(WithHeadingWeights, ObservationCurvature, ::testing::Values(0.0, 0.5, 4.0));

TEST(ObservationTerm, HasEveryMinimumOnTheBorder) {
  const ObservationTerm term{{2.0, 1.0}, 0.0};
  for (const double heading_error : {-2.0, 0.0, 0.7}) {
    const Point<2> minimum = Rotation<2>(heading_error).matrix() * term.measured;
    EXPECT_TRUE(term.is_convex_at(heading_error, 1.001 * minimum));
    EXPECT_FALSE(term.is_convex_at(heading_error, 0.999 * minimum));
  }
}

TEST(ObservationTerm, IsConvexFromItsBorderOn) {
  for (const double heading_error : {-1.2, -0.3, 0.0, 0.8}) {
    const ObservationTerm term{{3.0, 4.0}, 6.0};
    const Point<2> direction(0.6, 0.8);
    const double border = term.border(heading_error);
    EXPECT_TRUE(term.is_convex_at(heading_error, 1.001 * border * direction));
    EXPECT_FALSE(term.is_convex_at(heading_error, 0.999 * border * direction));
  }
}

}  // namespace
}  // namespace mapjoin
