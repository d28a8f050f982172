// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <ctime>
#include <iostream>
#include <mapjoin/join/association/frames/map_alignment.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/feature_worlds.hpp>

namespace mapjoin::testing {
namespace {

/// The maps of two drives in one world, each 20 m wide and 16 m deep, the second one `apart` metres beside the first.
template <int Dim>
std::pair<DrivenMap<Dim>, DrivenMap<Dim>> two_maps(double apart, FeatureWorldOptions options, std::uint64_t seed) {
  RandomStream random(seed, 0);
  const auto world = feature_world<Dim>(options, random);
  const double middle = 0.5 * options.side;
  Point<Dim> first = Point<Dim>::Constant(middle);
  first[0] = options.range;
  first[1] = middle - 8.0;
  Point<Dim> second = first;
  second[0] += apart;
  auto a = driven_map<Dim>(world, lanes<Dim>(first, 20.0, 16.0, 8.0), options, random);
  auto b = driven_map<Dim>(world, lanes<Dim>(second, 20.0, 16.0, 8.0), options, random);
  return {std::move(a), std::move(b)};
}

template <int Dim>
MapAlignment aligned(const DrivenMap<Dim>& a, const DrivenMap<Dim>& b, double range) {
  const auto density = density_of(a, range);
  const SightingChance sees = chance_of(range);
  return align_maps(a.map, b.map, AlignmentModel<Dim>{density, sees});
}

template <int Dim>
std::size_t shared_count(const DrivenMap<Dim>& a, const DrivenMap<Dim>& b) {
  std::vector<std::size_t> both;
  std::ranges::set_intersection(a.truth, b.truth, std::back_inserter(both));
  return both.size();
}

template <int Dim>
FeatureWorldOptions options_of(Layout layout) {
  FeatureWorldOptions options;
  options.layout = layout;
  options.side = 110.0;
  if constexpr (Dim == 3) options = {layout, 70.0, 5.0, 9.0};
  return options;
}

template <typename D>
class MapAlignmentTest : public ::testing::Test {};
TYPED_TEST_SUITE(MapAlignmentTest, Dimensions);

TYPED_TEST(MapAlignmentTest, FindsWhichFeaturesOverlappingMapsShare) {
  constexpr int kDim = TypeParam::value;
  const auto options = options_of<kDim>(Layout::kRandom);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto maps = two_maps<kDim>(12.0, options, seed);
    const auto& a = maps.first;
    const auto& b = maps.second;
    const MapAlignment found = aligned(a, b, options.range);
    EXPECT_EQ(found.status, AlignmentStatus::kFound) << seed;
    EXPECT_GE(found.pairs.size(), shared_count(a, b) / 2) << seed;
    const auto is_true = [&](const Pairing& p) { return a.truth[p.known] == b.truth[p.sighting]; };
    EXPECT_GE(std::ranges::count_if(found.pairs, is_true), 0.97 * static_cast<double>(found.pairs.size())) << seed;
  }
}

TYPED_TEST(MapAlignmentTest, FindsMapsThatShareAStripOfFeatures) {
  constexpr int kDim = TypeParam::value;
  const auto options = options_of<kDim>(Layout::kRandom);
  int missed = 0;
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto [a, b] = two_maps<kDim>(kDim == 2 ? 33.0 : 32.0, options, seed);
    const std::size_t shared = shared_count(a, b);
    if (shared < 8) continue;
    ++tried;
    const MapAlignment found = aligned(a, b, options.range);
    missed += found.status != AlignmentStatus::kFound;
  }
  EXPECT_GT(tried, 0);
  EXPECT_LE(missed, kDim == 2 ? 0 : 2) << "of " << tried;
}

TEST(MapAlignment, OfMapsOfAThousandFeaturesIsFound) {
  FeatureWorldOptions options;
  options.side = 96.0;
  RandomStream random(1, 0);
  const auto world = feature_world<2>(options, random);
  const auto path = lanes<2>({6.0, 6.0}, 84.0, 84.0, 12.0, 4.0);
  const auto a = driven_map<2>(world, path, options, random);
  const auto b = driven_map<2>(world, path, options, random);
  EXPECT_GT(a.map.features.size(), 990U);
  const auto density = density_of(a, options.range);
  const SightingChance sees = chance_of(options.range);
  const std::clock_t begin = std::clock();
  const MapAlignment found = align_maps(a.map, b.map, AlignmentModel<2>{density, sees});
  std::cout << static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC << " s of CPU\n";
  EXPECT_EQ(found.status, AlignmentStatus::kFound);
  EXPECT_GT(found.pairs.size(), 500U);
}

template <int Dim>
void expect_apart(Layout layout, std::uint64_t seeds) {
  const auto options = options_of<Dim>(layout);
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto [a, b] = two_maps<Dim>(Dim == 2 ? 60.0 : 45.0, options, seed);
    const MapAlignment found = aligned(a, b, options.range);
    EXPECT_NE(found.status, AlignmentStatus::kFound) << seed << ": " << found.score << " beside " << found.other_score;
  }
}

class DisjointWorlds : public ::testing::TestWithParam<Layout> {};

TEST_P(DisjointWorlds, StayApartInThePlane) {
  expect_apart<2>(GetParam(), 200);
}

TEST_P(DisjointWorlds, StayApartInSpace) {
  expect_apart<3>(GetParam(), 50);
}

INSTANTIATE_TEST_SUITE_P(OfEveryLayout, DisjointWorlds,
                         ::testing::Values(Layout::kRandom, Layout::kJittered, Layout::kLattice, Layout::kBlocks));

}  // namespace
}  // namespace mapjoin::testing
