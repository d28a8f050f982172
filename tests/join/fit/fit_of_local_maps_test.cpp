// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/run.hpp>
#include <tests/support/closing_world.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// Local maps of a world without closures.
template <int Dim>
SubmapSet<Dim> local_maps(std::uint64_t seed) {
  return testing::small_submap_set(testing::ClosingWorld<Dim>(120, seed, 0).log, 15.0);
}

template <typename D>
class FitOfLocalMapsTest : public ::testing::Test {};
TYPED_TEST_SUITE(FitOfLocalMapsTest, testing::Dimensions, );

TYPED_TEST(FitOfLocalMapsTest, NamesALocalMapsFeatureThatIsNotTheOneItIsSaidToBe) {
  auto set = local_maps<TypeParam::value>(4);
  auto& map = set.graph.submaps[set.graph.submaps.size() / 2];
  const auto others = [&](FeatureIndex feature) { return std::ranges::find(map.features, feature) == map.features.end(); };
  FeatureIndex wrong = 0;
  while (!others(wrong)) ++wrong;
  EXPECT_EQ(run(set, {}).value().fit.verdict, Verdict::kFits);
  // A feature that at least two other maps have, too.
  std::size_t f = 0;
  const auto maps_with = [&](FeatureIndex feature) {
    return std::ranges::count_if(set.graph.submaps,
                                 [&](const auto& of) { return std::ranges::count(of.features, feature) > 0; });
  };
  while (maps_with(map.features[f]) < 3) ++f;
  map.features[f] = wrong;
  const GoodnessOfFit fit = run(set, {}).value().fit;
  ASSERT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_EQ(fit.misfits.at(0).kind, PartKind::kMapFeature);
  EXPECT_EQ(fit.misfits.at(0).to, PoseOrFeature(wrong));
}

TEST(FitOfLocalMaps, NamesLocalMapsThatChangedPlaces) {
  auto set = local_maps<2>(4);
  auto& maps = set.graph.submaps;
  std::swap(maps[2], maps[4]);
  std::swap(maps[2].base, maps[4].base);
  std::swap(maps[2].poses, maps[4].poses);
  const GoodnessOfFit fit = run(set, {}).value().fit;
  ASSERT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_EQ(fit.misfits.at(0).kind, PartKind::kLocalMap);
  EXPECT_THAT((std::vector{maps[2].base, maps[4].base}), ::testing::Contains(fit.misfits.at(0).from));
}

TYPED_TEST(FitOfLocalMapsTest, NamesTheLastLocalMapWhereItStandsTwice) {
  auto set = local_maps<TypeParam::value>(4);
  auto copy = set.graph.submaps.back();
  copy.base = copy.poses.back();
  copy.poses.back() = PoseIndex(set.poses.size());
  set.poses.push_back({0, 1000});
  set.segments.push_back({copy.base, copy.poses.back(), true});
  set.graph.submaps.push_back(copy);
  const GoodnessOfFit fit = run(set, {}).value().fit;
  ASSERT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_EQ(fit.misfits.at(0).kind, PartKind::kLocalMap);
  EXPECT_THAT((std::vector{copy.base, set.graph.submaps[set.graph.submaps.size() - 2].base}),
              ::testing::Contains(fit.misfits.at(0).from));
}

TEST(FitOfLocalMaps, NamesTheLocalMapOfAnotherSession) {
  auto set = local_maps<2>(4);
  auto& map = set.graph.submaps[4];
  const auto strange = local_maps<2>(11).graph.submaps[4];
  for (std::size_t k = 0; k < std::min(map.features.size(), strange.features.size()); ++k) {
    map.feature_estimates[k] = strange.feature_estimates[k];
  }
  map.pose_estimates = strange.pose_estimates;
  const GoodnessOfFit fit = run(set, {}).value().fit;
  ASSERT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_EQ(fit.misfits.at(0).kind, PartKind::kLocalMap);
  EXPECT_EQ(fit.misfits.at(0).from, map.base);
}

}  // namespace
}  // namespace mapjoin
