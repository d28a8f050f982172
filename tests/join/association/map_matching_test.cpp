// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/map_matching.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/wood.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The local maps of a wood, with their information matrices multiplied by `weight`.
template <int Dim>
SubmapSet<Dim> maps_of_a_wood(double weight) {
  SubmapSet<Dim> set = testing::small_submap_set(testing::wood<Dim>(1).log, 20.0);
  for (auto& map : set.graph.submaps) map.information *= weight;
  return set;
}

/// The pairs of maps with features that may be the same and may be mistaken for at most ten others; no feature of a map is
/// known to be that of another.
template <int Dim>
std::vector<MapPair<Dim>> pairs_within_reach(const SubmapSet<Dim>& set) {
  const Identities identities = testing::all_apart(set);
  std::vector<std::vector<Point<Dim>>> seen_at_once;
  for (const auto& map : set.graph.submaps) seen_at_once.push_back(map.feature_estimates);
  const NeighbourDensity<Dim> density(seen_at_once);
  const auto estimate = estimate_of(renamed(set, identities), {}).value();
  return MapMatching<Dim>(estimate, identities, density, AssociationMethod::kJcbb, 0.99, 100.0).pairs(10.0, {});
}

template <typename D>
class MapMatchingTest : public ::testing::Test {};
TYPED_TEST_SUITE(MapMatchingTest, testing::Dimensions);

TYPED_TEST(MapMatchingTest, FindsMapsWhoseFeaturesMayBeTheSame) {
  EXPECT_FALSE(pairs_within_reach(maps_of_a_wood<TypeParam::value>(1.0)).empty());
}

TYPED_TEST(MapMatchingTest, ReachesNoMapsOfWhichNextToNothingIsKnown) {
  for (const double weight : {1e-12, 1e-100, 1e-200, 1e-309}) {
    EXPECT_TRUE(pairs_within_reach(maps_of_a_wood<TypeParam::value>(weight)).empty()) << weight;
  }
}

}  // namespace
}  // namespace mapjoin
