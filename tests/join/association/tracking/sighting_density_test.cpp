// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/tracking/sighting_density.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

template <typename D>
class SightingDensityTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  using Noise = PointMatrix<kDim>;

  FeatureFactor<kDim> seen_from(PoseIndex pose, const Noise& information) {
    return {pose, FeatureIndex(0), random.vector<kDim>(5.0), information};
  }
  /// A local map of one pose and of features with this information.
  LocalMap<kDim> local_map(std::size_t features, const Noise& information) {
    LocalMap<kDim> map;
    map.poses = {1};
    map.features.resize(features);
    map.information.setIdentity(map.row(1 + features), map.row(1 + features));
    for (std::size_t f = 0; f < features; ++f) {
      map.feature_estimates.push_back(random.vector<kDim>(5.0));
      map.information.template block<kDim, kDim>(map.row(1 + f), map.row(1 + f)) = information;
    }
    return map;
  }

  testing::Random random{7};
};
TYPED_TEST_SUITE(SightingDensityTest, testing::Dimensions);

TYPED_TEST(SightingDensityTest, TakesTheNoiseOfTheMeanInformation) {
  constexpr int kDim = TypeParam::value;
  using Noise = PointMatrix<kDim>;
  const std::vector<FeatureFactor<kDim>> seen = {this->seen_from(0, 4.0 * Noise::Identity())};
  EXPECT_TRUE(mean_noise<kDim>(seen, {}).isApprox(0.25 * Noise::Identity()));
  const Noise mean = mean_noise<kDim>(seen, {this->local_map(3, 8.0 * Noise::Identity())});
  EXPECT_TRUE(mean.isApprox(Noise::Identity() / 7.0));
}

TYPED_TEST(SightingDensityTest, TakesNoNoiseWhereSightingsDetermineNoPoint) {
  constexpr int kDim = TypeParam::value;
  PointMatrix<kDim> range = PointMatrix<kDim>::Zero();
  range(0, 0) = 1.0;
  const std::vector<FeatureFactor<kDim>> seen = {this->seen_from(0, range)};
  EXPECT_TRUE(mean_noise<kDim>(seen, {}).isZero(0.0));
}

TYPED_TEST(SightingDensityTest, CountsWhatAPoseOrALocalMapSeesAtOnce) {
  constexpr int kDim = TypeParam::value;
  const PointMatrix<kDim> W = 1e4 * PointMatrix<kDim>::Identity();
  std::vector<FeatureFactor<kDim>> seen;
  std::vector<std::vector<Point<kDim>>> sets(2);
  for (const std::size_t pose : {0U, 1U}) {
    for (int k = 0; k < 20; ++k) {
      seen.push_back(this->seen_from(PoseIndex(pose), W));
      sets[pose].push_back(seen.back().measured);
    }
  }
  const auto map = this->local_map(20, W);
  sets.insert(sets.begin(), map.feature_estimates);
  const NeighbourDensity<kDim> expected(sets, W.inverse());
  EXPECT_NEAR(density_of<kDim>(seen, {map}).overall(), expected.overall(), 1e-12 * expected.overall());
}

}  // namespace
}  // namespace mapjoin
