// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/store.hpp>
#include <stdexcept>
#include <tests/support/dimensions.hpp>
#include <tests/support/stored_maps.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using testing::Random;
using testing::TemporaryFolder;

/// Maps between successive poses; the last one does not move: it starts and ends at one pose.
template <int Dim>
SubmapSet<Dim> random_submap_set(Random& random) {
  SubmapSet<Dim> set;
  set.source = "maps.tar";
  set.conventions.repairs.indefinite = 3;
  for (std::uint64_t k = 0; k < 4; ++k) set.poses.push_back({0, k});
  for (std::uint64_t key = 10; key < 15; ++key) set.features.push_back({key});
  for (PoseIndex k = 0; k < 3; ++k) {
    set.segments.push_back({k, k + 1, true});
    set.graph.submaps.push_back(testing::random_map<Dim>(random, set.segments.back(), 5));
  }
  set.segments.push_back({3, 3, true});
  LocalMap<Dim> still = testing::random_map<Dim>(random, set.segments.back(), 5);
  still.poses.clear();
  still.pose_estimates.clear();
  still.information = still.information.bottomRightCorner(5 * Dim, 5 * Dim).eval();
  set.graph.submaps.push_back(still);
  return set;
}

template <typename Dimension>
class StoreSubmapSet : public ::testing::Test {};
TYPED_TEST_SUITE(StoreSubmapSet, testing::Dimensions);

TYPED_TEST(StoreSubmapSet, GivesBackTheMapsOfOthersAsTheyWere) {
  constexpr int kDim = TypeParam::value;
  const TemporaryFolder folder;
  const auto path = folder.path() / "store";
  Random random;
  SubmapSet<kDim> set = random_submap_set<kDim>(random);
  set.features_are_shared = true;
  ASSERT_TRUE(write_store(set, path));

  const auto opened = open_maps(path);
  ASSERT_TRUE(opened) << opened.error().message;
  const auto& back = std::get<SubmapSet<kDim>>(*opened);
  EXPECT_EQ(back.source, path.string());
  EXPECT_EQ(back.poses, set.poses);
  EXPECT_EQ(back.features, set.features);
  EXPECT_EQ(back.segments, set.segments);
  EXPECT_TRUE(testing::same(back.graph.submaps, set.graph.submaps));
  EXPECT_EQ(back.conventions.repairs.indefinite, 3);
  EXPECT_TRUE(back.features_are_shared);
}

TYPED_TEST(StoreSubmapSet, IsOneWithoutAnyObservation) {
  constexpr int kDim = TypeParam::value;
  Random random;
  StoredMaps<kDim> stored = testing::random_stored_maps<kDim>(random, 2);
  EXPECT_FALSE(has_maps_alone(stored));
  Log<kDim> bare;
  bare.poses = stored.log.poses;
  bare.graph.feature_factors = {stored.log.observations().front()};
  stored.log = bare;
  EXPECT_FALSE(has_maps_alone(stored));
  stored.log.graph.feature_factors.clear();
  EXPECT_TRUE(has_maps_alone(stored));
  stored.maps.clear();
  EXPECT_FALSE(has_maps_alone(stored));
}

TYPED_TEST(StoreSubmapSet, HoldsMapsAlone) {
  constexpr int kDim = TypeParam::value;
  const TemporaryFolder folder;
  Random random;
  SubmapSet<kDim> set = random_submap_set<kDim>(random);
  set.graph.pose_factors.push_back(testing::random_pose_observation<kDim>(random, 0, 2));
  EXPECT_THROW(static_cast<void>(write_store(set, folder.path() / "store")), std::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "store"));
}

}  // namespace
}  // namespace mapjoin
