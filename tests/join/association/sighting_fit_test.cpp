// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/sighting_fit.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/wood.hpp>

namespace mapjoin {
namespace {

TEST(SightingFitTest, NamesTheMapThatTookAFeatureForAnother) {
  const SubmapSet<2> set = testing::small_submap_set(testing::wood<2>(1).log, 20.0);
  std::vector<std::size_t> labels;
  for (const auto& map : set.graph.submaps) {
    for (const FeatureIndex feature : map.features) labels.push_back(feature.position());
  }
  const auto sightings = sightings_of(set);
  // Two features of one map swap their ids.
  constexpr std::size_t kMap = 7;
  std::vector<std::size_t> of_map;
  for (std::size_t s = 0; s < sightings.size(); ++s) {
    if (sightings[s].map == kMap) of_map.push_back(s);
  }
  std::swap(labels[of_map[0]], labels[of_map[1]]);
  const Identities identities(sightings, labels);
  const auto tests = tests_of(estimate_of(renamed(set, identities), {}).value(), identities);
  auto found = misfits(tests, chi_squared_quantile(0.9999, 2));
  ASSERT_GE(found.size(), 2U);
  std::ranges::sort(found, std::greater<>(), &SightingTest::chi2);
  EXPECT_EQ(found[0].map, kMap);
  EXPECT_EQ(found[1].map, kMap);
}

}  // namespace
}  // namespace mapjoin
