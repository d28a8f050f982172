// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/check/fit.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::ElementsAre;

/// Residuals of `count` observations of three rows each, with normal errors `times` as large as stated.
std::vector<WeighedResidual> normal_residuals(std::size_t count, double times, std::uint64_t seed = 1) {
  RandomStream random(seed, 0);
  std::vector<WeighedResidual> residuals;
  for (std::size_t i = 0; i < count; ++i) {
    double chi2 = 0.0;
    for (int row = 0; row < 3; ++row) chi2 += std::pow(times * random.normal(), 2);
    residuals.push_back({chi2, 3});
  }
  return residuals;
}

std::string name(std::size_t i) {
  return "number " + std::to_string(i);
}

std::vector<std::string> checks_of(const std::vector<KindFit>& fits, std::int64_t dof) {
  std::vector<std::string> checks;
  for (const Finding& finding : check_fit(fits, dof)) checks.push_back(finding.check);
  return checks;
}

TEST(Fit, OfErrorsAsLargeAsStatedIsFine) {
  const KindFit fit = kind_fit("closures", normal_residuals(5000, 1.0), name);
  EXPECT_EQ(fit.rows, 15000);
  EXPECT_NEAR(fit.scale, 1.0, 0.05);
  EXPECT_NEAR(fit.chi2, 15000.0, 600.0);
  EXPECT_THAT(checks_of({fit}, 15000), ElementsAre());
}

TEST(Fit, TellsErrorsThatAreLargerOrSmallerThanStated) {
  EXPECT_THAT(checks_of({kind_fit("closures", normal_residuals(1000, 1.7), name)}, 3000), ElementsAre("too_certain"));
  EXPECT_THAT(checks_of({kind_fit("closures", normal_residuals(1000, 0.4), name)}, 3000), ElementsAre("too_cautious"));
}

TEST(Fit, SaysNothingOfErrorsThatAreNotFarFromStated) {
  for (const double times : {0.6, 1.4}) {
    EXPECT_THAT(checks_of({kind_fit("closures", normal_residuals(1000, times), name)}, 3000), ElementsAre()) << times;
  }
}

TEST(Fit, CallsNothingAnOutlierThatItsCovarianceAllows) {
  auto residuals = normal_residuals(1000, 0.3);
  residuals[17].chi2 = 15.0;  // far from these, but common among a thousand observations of three rows
  EXPECT_EQ(kind_fit("closures", residuals, name).outliers.count, 0u);
}

TEST(Fit, FewResidualsAreNotTypicalOfThemselves) {
  for (const std::size_t count : {1U, 2U, 6U}) {
    EXPECT_EQ(kind_fit("closures", std::vector<WeighedResidual>(count, {100.0, 3}), name).outliers.count, count);
    EXPECT_EQ(kind_fit("closures", std::vector<WeighedResidual>(count, {10.0, 3}), name).outliers.count, 0U);
  }
  EXPECT_EQ(kind_fit("closures", std::vector<WeighedResidual>(7, {100.0, 3}), name).outliers.count, 0U);
}

TEST(Fit, IsJudgedFromTwentyRowsOn) {
  for (const auto& [chi2, check] : {std::pair(9.0, "too_certain"), std::pair(0.2, "too_cautious")}) {
    const auto residuals_of = [&, of_each = chi2](std::size_t count) {
      return std::vector<WeighedResidual>(count, {3.0 * of_each, 3});
    };
    EXPECT_THAT(checks_of({kind_fit("closures", residuals_of(6), name)}, 18), ElementsAre()) << check;
    EXPECT_THAT(checks_of({kind_fit("closures", residuals_of(7), name)}, 21), ElementsAre(check));
  }
}

TEST(Fit, FindsOutliersWhateverTheScale) {
  for (const double times : {0.3, 1.0, 5.0}) {
    auto residuals = normal_residuals(1000, times);
    residuals[17].chi2 = 100.0 * times * times + 50.0;
    residuals[400].chi2 = 200.0 * times * times + 50.0;
    const KindFit fit = kind_fit("closures", residuals, name);
    ASSERT_EQ(fit.outliers.count, 2u) << times;
    EXPECT_EQ(fit.outliers.names[0].substr(0, 10), "number 400");
    EXPECT_EQ(fit.outliers.names[1].substr(0, 9), "number 17");
    EXPECT_EQ(fit.worst, residuals[400].chi2);
  }
}

TEST(Fit, TakesForAnOutlierWhatOneOfAThousandKindsOfSoManyHas) {
  std::vector<WeighedResidual> residuals(500, {chi_squared_quantile(0.5, 3.0), 3});
  const double most = chi_squared_quantile(1.0 - 1e-3 / 500.0, 3.0);
  residuals[3].chi2 = 0.99 * most;
  residuals[5].chi2 = 1.01 * most;
  const KindFit fit = kind_fit("closures", residuals, name);
  ASSERT_EQ(fit.outliers.count, 1u);
  EXPECT_EQ(fit.outliers.names[0].substr(0, 8), "number 5");
}

TEST(Fit, KnowsNothingOfWhatMeasuresNothing) {
  const KindFit fit = kind_fit("closures", {{0.0, 0}, {0.0, 0}}, name);
  EXPECT_TRUE(std::isnan(fit.scale));
  EXPECT_EQ(fit.outliers.count, 0u);
}

template <typename Dimension>
class FitOf : public ::testing::Test {};
TYPED_TEST_SUITE(FitOf, Dimensions);

TYPED_TEST(FitOf, ALogHasItsKindsWithTheChi2OfAll) {
  constexpr int Dim = TypeParam::value;
  const auto world = small_world<Dim>();
  const auto fits = fits_of(world.log, world.truth);
  const Chi2 all = log_chi2(world.log, {world.truth.poses, world.truth.features});
  ASSERT_EQ(fits.size(), 3u);
  EXPECT_NEAR(fits[0].chi2, all.odometry, 1e-9 * all.odometry);
  EXPECT_NEAR(fits[1].chi2, all.closures, 1e-9 * all.closures);
  EXPECT_NEAR(fits[2].chi2, all.observations, 1e-9 * all.observations);
  EXPECT_EQ(fits[0].kind, "odometry");
  EXPECT_EQ(fits[2].count, world.log.observations().size());
}

}  // namespace
}  // namespace mapjoin::testing
