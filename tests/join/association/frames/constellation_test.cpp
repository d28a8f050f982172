// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/association/frames/feature_map.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin::testing {
namespace {

template <int Dim>
FeatureMap<Dim> map_of(const std::vector<Point<Dim>>& features) {
  const auto rows = static_cast<Eigen::Index>(features.size()) * Dim;
  return {features, 1e-4 * Eigen::MatrixXd::Identity(rows, rows), {}};
}

template <int Dim>
std::vector<Point<Dim>> scattered(std::size_t count, unsigned seed) {
  Random random(seed);
  std::vector<Point<Dim>> points;
  for (std::size_t k = 0; k < count; ++k) points.push_back(random.vector<Dim>(10.0));
  return points;
}

template <typename D>
class ConstellationTest : public ::testing::Test {};
TYPED_TEST_SUITE(ConstellationTest, Dimensions);

TYPED_TEST(ConstellationTest, LookAlikeInAnyFrame) {
  constexpr int kDim = TypeParam::value;
  const auto points = scattered<kDim>(40, 1);
  const auto frame = Random(2).pose<kDim>(50.0, 3.0);
  std::vector<Point<kDim>> moved;
  for (const auto& p : points) moved.push_back(transform(frame, p));
  std::ranges::reverse(moved);
  const auto found = constellations_alike(map_of<kDim>(points), map_of<kDim>(moved), 0.99);
  EXPECT_GE(found.size(), points.size());
  std::size_t whole = 0;
  for (const Constellation& constellation : found) {
    const auto is_true = [&](const Pairing& p) { return p.sighting == points.size() - 1 - p.known; };
    if (std::ranges::all_of(constellation, is_true)) whole += constellation.size() == 9;
  }
  EXPECT_EQ(whole, points.size()) << "each feature with its eight neighbours";
}

TEST(Constellation, IsNotAlikeInAMirror) {
  const auto points = scattered<2>(30, 3);
  std::vector<Point<2>> mirrored;
  for (const auto& p : points) mirrored.emplace_back(-p[0], p[1]);
  for (const Constellation& c : constellations_alike(map_of<2>(points), map_of<2>(mirrored), 0.99)) EXPECT_LT(c.size(), 5U);
}

TEST(Constellation, IsFoundAmongManyThatLookAlike) {
  std::vector<Point<2>> grid;
  for (int x = 0; x < 5; ++x) {
    for (int y = 0; y < 5; ++y) grid.emplace_back(3.0 * x, 3.0 * y);
  }
  const auto map = map_of<2>(grid);
  std::size_t itself = 0;
  for (const Constellation& constellation : constellations_alike(map, map, 0.99)) {
    itself += std::ranges::all_of(constellation, [](const Pairing& p) { return p.known == p.sighting; });
  }
  EXPECT_GE(itself, 9U) << "of every tree inside";
}

TEST(Constellation, IsFoundAsFarOffAsMostFeaturesAreUncertain) {
  auto points = scattered<2>(40, 5);
  for (std::size_t k = 0; k < 4; ++k) points[k] += Point<2>(30.0, 30.0);
  auto seen = points;
  Random random(6);
  FeatureMap<2> second = map_of<2>(points);
  for (std::size_t k = 4; k < points.size(); ++k) {  // the first four, which stand apart, keep their places and their certainty
    seen[k] += random.vector<2>(0.2);
    second.covariance.diagonal().segment<2>(2 * static_cast<Eigen::Index>(k)).setConstant(0.04);
  }
  second.features = seen;
  std::size_t itself = 0;
  for (const Constellation& constellation : constellations_alike(map_of<2>(points), second, 0.99)) {
    itself += constellation.front().known == constellation.front().sighting && constellation.size() >= 7;
  }
  EXPECT_GE(itself, 30U);
}

/// Features known to a centimetre are off by up to half a metre in each coordinate; far away there are many that are known to
/// half a metre only.
TEST(Constellation, IsAlikeAsFarAsItsOwnFeaturesAreUncertain) {
  auto points = scattered<2>(12, 7);
  for (const auto& p : scattered<2>(40, 8)) points.push_back(p + Point<2>(100.0, 0.0));
  FeatureMap<2> second = map_of<2>(points);
  Random random(9);
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (k < 12) second.features[k] += random.vector<2>(0.5);
    if (k >= 12) second.covariance.diagonal().segment<2>(2 * static_cast<Eigen::Index>(k)).setConstant(0.25);
  }
  std::size_t certain = 0;
  std::size_t uncertain = 0;
  for (const Constellation& constellation : constellations_alike(map_of<2>(points), second, 0.99)) {
    const Pairing& centre = constellation.front();
    if (centre.known == centre.sighting) ++(centre.known < 12 ? certain : uncertain);
  }
  EXPECT_EQ(certain, 0U);
  EXPECT_EQ(uncertain, 40U);
}

TEST(Constellation, HasFourFeaturesAtLeast) {
  const auto three = map_of<2>({{0.0, 0.0}, {3.0, 0.5}, {1.0, 4.0}});
  EXPECT_TRUE(constellations_alike(three, three, 0.99).empty());
}

}  // namespace
}  // namespace mapjoin::testing
