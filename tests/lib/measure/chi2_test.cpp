// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/measure/chi2.hpp>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::Random;

template <typename D>
class Chi2Test : public ::testing::Test {};
TYPED_TEST_SUITE(Chi2Test, testing::Dimensions);

/// A log of four poses and two features with at least one observation of every kind, far from consistent.
template <int Dim>
Log<Dim> random_log(Random& random) {
  const auto edge = [&](PoseIndex base, PoseIndex target) {
    return PoseFactor<Dim>{base, target, random.pose<Dim>(), random.information<kPoseDof<Dim>>()};
  };
  const auto observation = [&](PoseIndex base, FeatureIndex target) {
    return FeatureFactor<Dim>{base, target, random.vector<Dim>(5.0), random.information<Dim>()};
  };
  Log<Dim> log;
  log.poses = {{0, 0}, {0, 1}, {0, 2}, {0, 3}};
  log.features = {{0}, {1}};
  log.sessions = {{0, 4}};
  log.graph.pose_factors = {edge(0, 1), edge(2, 1), edge(2, 3), edge(3, 0), edge(kWorld, 2)};
  log.graph.feature_factors = {observation(0, 0), observation(2, 0), observation(3, 1), observation(kWorld, 1)};
  return log;
}

template <int Dim>
Values<Dim> random_values(const Log<Dim>& log, Random& random) {
  Values<Dim> values;
  for (std::size_t i = 0; i < log.poses.size(); ++i) values.poses.push_back(random.pose<Dim>());
  for (std::size_t i = 0; i < log.features.size(); ++i) values.features.push_back(random.vector<Dim>(5.0));
  return values;
}

TYPED_TEST(Chi2Test, EqualsTheReferenceOptimisersCostOverAllKinds) {
  constexpr int kDim = TypeParam::value;
  Random random;
  for (int i = 0; i < 10; ++i) {
    const Log<kDim> log = random_log<kDim>(random);
    const auto values = random_values(log, random);
    const Chi2 chi2 = log_chi2(log, values);
    EXPECT_GT(std::min({chi2.odometry, chi2.closures, chi2.observations, chi2.priors}), 0.0);
    const double reference = testing::ceres_optimum(log, values, {.max_iterations = 0}).initial_chi2;
    EXPECT_NEAR(chi2.total(), reference, 1e-12 * reference);
  }
}

TYPED_TEST(Chi2Test, RefusesValuesOfAnotherLog) {
  constexpr int kDim = TypeParam::value;
  Random random;
  const Log<kDim> log = random_log<kDim>(random);
  EXPECT_THROW(log_chi2(log, {}), std::invalid_argument);
}

TYPED_TEST(Chi2Test, DegreesOfFreedomCountMeasuredRowsOnly) {
  constexpr int kDim = TypeParam::value;
  Random random;
  Log<kDim> log = random_log<kDim>(random);
  const std::int64_t rows = 5 * kPoseDof<kDim> + 4 * kDim;
  const std::int64_t unknowns = 4 * kPoseDof<kDim> + 2 * kDim;
  EXPECT_EQ(degrees_of_freedom(log, 0), rows - unknowns);
  EXPECT_EQ(degrees_of_freedom(log, 1), rows - unknowns + kPoseDof<kDim>);
  EXPECT_EQ(degrees_of_freedom(log), degrees_of_freedom(log, log.graph.fixed.size())) << "priors hold it";

  // A position without rotation, as from GPS, and a bearing, which measures one coordinate of a point less.
  auto& gps = log.graph.pose_factors.back().information;
  gps.template rightCols<kRotationDof<kDim>>().setZero();
  gps.template bottomRows<kRotationDof<kDim>>().setZero();
  const Point<kDim> direction = random.vector<kDim>().normalized();
  log.graph.feature_factors.front().information = 1e6 * (PointMatrix<kDim>::Identity() - direction * direction.transpose());
  EXPECT_EQ(degrees_of_freedom(log, 0), rows - unknowns - kRotationDof<kDim> - 1);
}

}  // namespace
}  // namespace mapjoin
