// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/feature_candidates.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/wood.hpp>

namespace mapjoin {
namespace {

/// The local maps of a wood, whose features have no names.
template <typename D>
class FeatureCandidatesTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  FeatureCandidatesTest() {
    for (const NamedSighting& seen : named_sightings(set)) names.push_back(seen.name);
  }
  /// True if a map sees the tree of this feature.
  bool has_tree_of(FeatureIndex feature, std::size_t map) const {
    return std::ranges::any_of(identities.features_in(map), [&](FeatureIndex f) { return names[f] == names[feature]; });
  }

  SubmapSet<kDim> set = testing::small_submap_set(testing::wood<kDim>(1).log, 20.0);
  Identities identities = testing::all_apart(set);
  Table<FeatureIndex, FeatureIndex> names;  // the trees, by feature
  FeatureEstimate<kDim> estimate = estimate_of(renamed(set, identities), {}).value();
  double gate = chi_squared_quantile(0.999, kDim);
  NeighbourDensity<kDim> density{std::vector<std::vector<Point<kDim>>>{set.graph.submaps.front().feature_estimates}};
  FeatureCandidates<kDim> candidates{estimate, identities, density, gate};
};
TYPED_TEST_SUITE(FeatureCandidatesTest, testing::Dimensions);

TYPED_TEST(FeatureCandidatesTest, HaveTheTreeThatTheMapBeforeSeesToo) {
  std::size_t both_see = 0;
  std::size_t found = 0;
  for (std::size_t map = 1; map < this->identities.map_count(); ++map) {
    const auto open = this->candidates.of_map(map, true);
    for (const FeatureIndex f : this->identities.features_in(map)) both_see += this->has_tree_of(f, map - 1) ? 1U : 0U;
    for (std::size_t k = 0; k < open.features.size(); ++k) {
      for (const auto& candidate : open.candidates[k]) {
        const bool is_of_map_before = this->identities.sees(map - 1, candidate.feature);
        EXPECT_TRUE(is_of_map_before || this->identities.sees(map, candidate.feature));
        found += is_of_map_before && this->names[candidate.feature] == this->names[open.features[k]] ? 1U : 0U;
      }
    }
  }
  ASSERT_GT(both_see, 20U);
  EXPECT_GE(found, both_see * 99 / 100);
}

TYPED_TEST(FeatureCandidatesTest, AreWithinTheGateOfTheirDifference) {
  constexpr int kDim = TypeParam::value;
  const auto open = this->candidates.of_map(3, false);
  ASSERT_FALSE(open.features.empty());
  for (std::size_t k = 0; k < open.features.size(); ++k) {
    for (const auto& [other, confusable, covariance] : open.candidates[k]) {
      const FeatureIndex own = open.features[k];
      const Eigen::MatrixXd P = this->estimate.covariances->joint(std::vector<PoseOrFeature>{own, other}).value();
      const PointMatrix<kDim> C = P.template bottomLeftCorner<kDim, kDim>();
      const PointMatrix<kDim> S =
          P.template topLeftCorner<kDim, kDim>() + P.template bottomRightCorner<kDim, kDim>() - C - C.transpose();
      const Point<kDim> d = this->estimate.position(other) - this->estimate.position(own);
      EXPECT_TRUE(covariance.isApprox(S, 1e-6));
      EXPECT_LE(d.dot(covariance.inverse() * d), this->gate * (1.0 + 1e-9));
      EXPECT_NEAR(confusable, this->density.confusable_per_deviation() * std::sqrt(S.determinant()), 1e-6 * confusable);
    }
  }
}

}  // namespace
}  // namespace mapjoin
