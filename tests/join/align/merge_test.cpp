// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/align/alignment.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

/// Poses and features of a true world, cut into partial maps, each in a frame of its own.
template <typename D>
class MergeTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  MergeTest() {
    for (int k = 0; k < 12; ++k) {
      world.poses.push_back(random.pose<kDim>());
      world.features.push_back(random.vector<kDim>(5.0));
    }
  }

  /// The partial map of these poses and features in the frame of its first pose.
  PartialMap<kDim> partial(Table<PoseIndex, PoseIndex> poses, Table<FeatureIndex, FeatureIndex> features = {}) const {
    PartialMap<kDim> partial;
    const Pose<kDim> frame = world.pose(poses.front());
    for (const PoseIndex p : poses) partial.state.poses.push_back(between(frame, world.pose(p)));
    for (const FeatureIndex f : features) partial.state.features.push_back(transform_into(frame, world.features[f]));
    partial.poses = std::move(poses);
    partial.features = std::move(features);
    return partial;
  }
  PoseFactor<kDim> closure(PoseIndex base, PoseIndex target) const {
    return {base, target, between(world.pose(base), world.pose(target)), PoseMatrix<kDim>::Identity()};
  }
  std::vector<PartialMap<kDim>> merge(std::vector<PartialMap<kDim>> partials,
                                      const std::vector<PoseFactor<kDim>>& closures = {}) const {
    std::vector<const PoseFactor<kDim>*> pointers;
    for (const auto& closure : closures) pointers.push_back(&closure);
    return merge_tied(std::move(partials), pointers, true);
  }
  void expect_true(const PartialMap<kDim>& found) const {
    const PartialMap<kDim> expected = partial(found.poses, found.features);
    const Pose<kDim> frame = found.state.poses.front();
    for (const PoseIndex p : indices(found.poses)) {
      EXPECT_LT(local(compose(frame, expected.state.poses[p]), found.state.poses[p]).norm(), 1e-9) << found.poses[p].value;
    }
    for (const FeatureIndex f : indices(found.features)) {
      EXPECT_LT((transform(frame, expected.state.features[f]) - found.state.features[f]).norm(), 1e-9)
          << found.features[f].value;
    }
  }

  testing::Random random{5};
  Values<kDim> world;
};
TYPED_TEST_SUITE(MergeTest, testing::Dimensions);

TYPED_TEST(MergeTest, TwoPartialMapsShareAPose) {
  const auto merged = this->merge({this->partial({0, 1}), this->partial({1, 2})});
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged[0].poses, (Table<PoseIndex, PoseIndex>{0, 1, 2}));
  this->expect_true(merged[0]);
}

TYPED_TEST(MergeTest, TheLeavesOfAStarAreAllMerged) {
  const auto merged = this->merge(
      {this->partial({1}), this->partial({3, 4}), this->partial({5}), this->partial({6}), this->partial({7, 9}, {2})},
      {this->closure(1, 3), this->closure(5, 4), this->closure(3, 6), this->closure(3, 9)});
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged[0].poses, (Table<PoseIndex, PoseIndex>{1, 3, 4, 5, 6, 7, 9}));
  EXPECT_EQ(merged[0].features, (Table<FeatureIndex, FeatureIndex>{FeatureIndex(2)}));
  this->expect_true(merged[0]);
}

TYPED_TEST(MergeTest, WhatNothingTiesStaysApart) {
  const auto merged = this->merge({this->partial({0}), this->partial({2}, {1}), this->partial({4}), this->partial({6}, {1})},
                                  {this->closure(4, 0)});
  ASSERT_EQ(merged.size(), 3u);
  EXPECT_EQ(merged[0].poses, (Table<PoseIndex, PoseIndex>{0, 4}));
  EXPECT_EQ(merged[1].poses, (Table<PoseIndex, PoseIndex>{PoseIndex(2)}));
  EXPECT_EQ(merged[2].poses, (Table<PoseIndex, PoseIndex>{PoseIndex(6)}));
}

TYPED_TEST(MergeTest, WhatTooFewFeaturesTieIsTiedByMoreThatOthersBring) {
  // The second partial map shares feature 0 with the first, and the other three with the third.
  const auto merged =
      this->merge({this->partial({0, 1}, {0}), this->partial({2}, {0, 1, 2, 3}), this->partial({1, 3}, {1, 2, 3})});
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged[0].poses, (Table<PoseIndex, PoseIndex>{0, 1, 2, 3}));
  this->expect_true(merged[0]);
}

TYPED_TEST(MergeTest, WhatTooFewFeaturesTieIsTriedAgainOnceOthersAreMerged) {
  // The first two partial maps share one feature with each of the others; only the three together fix how they lie.
  const auto merged = this->merge({this->partial({0}, {0, 1, 2}), this->partial({1}, {3, 4, 5}), this->partial({2, 3}, {0, 3}),
                                   this->partial({3, 4}, {1, 4}), this->partial({4, 5}, {2, 5})});
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged[0].poses, (Table<PoseIndex, PoseIndex>{0, 1, 2, 3, 4, 5}));
  this->expect_true(merged[0]);
}

}  // namespace
}  // namespace mapjoin
