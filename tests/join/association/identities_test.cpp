// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/join/association/identities.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using Pair = std::pair<FeatureIndex, FeatureIndex>;

/// Three maps with two features each, no two of which are the same.
Identities six_features() {
  return {{{0, 0}, {0, 0}, {1, 1}, {1, 1}, {2, 2}, {2, 2}}, {0, 1, 2, 3, 4, 5}};
}

TEST(IdentitiesTest, NumberFeaturesInTheOrderOfFirstSighting) {
  const Identities identities({{0, 0}, {0, 1}, {1, 2}, {1, 3}}, {7, 3, 7, 5});
  EXPECT_EQ(identities.feature_count(), 3U);
  EXPECT_EQ(identities.feature_of(2), FeatureIndex(0));
  EXPECT_EQ(identities.feature_of(3), FeatureIndex(2));
  EXPECT_THAT(identities.sightings_of(0), ElementsAre(0U, 2U));
  EXPECT_THAT(identities.features_in(1), ElementsAre(FeatureIndex(0), FeatureIndex(2)));
  EXPECT_TRUE(identities.features_in(2).empty());
}

TEST(IdentitiesTest, DoNotMergeWhatOneMapSeesAtOnce) {
  Identities identities = six_features();
  EXPECT_FALSE(identities.may_be_same(0, 1));
  // The last pair would bring together the features 0 and 1 of the first map.
  const auto moved = identities.merge(std::vector<Pair>{{0, 2}, {1, 4}, {2, 4}});
  EXPECT_THAT(moved, ElementsAre(ElementsAre(2U), ElementsAre(4U), ElementsAre()));
  EXPECT_EQ(identities.feature_count(), 4U);
  EXPECT_EQ(identities.feature_of(2), identities.feature_of(0));
  EXPECT_EQ(identities.feature_of(4), identities.feature_of(1));
}

TEST(IdentitiesTest, DoNotMergeAgainWhatWasToldApart) {
  Identities identities = six_features();
  identities.merge(std::vector<Pair>{{0, 2}, {0, 4}});
  identities.tell_apart(std::vector<std::size_t>{2});
  EXPECT_EQ(identities.feature_of(4), identities.feature_of(0));
  EXPECT_NE(identities.feature_of(2), identities.feature_of(0));
  EXPECT_FALSE(identities.may_be_same(identities.feature_of(2), identities.feature_of(0)));
  EXPECT_TRUE(identities.may_be_same(identities.feature_of(2), identities.feature_of(1)));
}

TEST(IdentitiesTest, MayMergeAgainWhatWasForgiven) {
  Identities identities = six_features();
  EXPECT_FALSE(identities.forgive());
  identities.merge(std::vector<Pair>{{0, 2}, {0, 4}});
  identities.tell_apart(std::vector<std::size_t>{2});
  EXPECT_TRUE(identities.forgive());
  EXPECT_TRUE(identities.may_be_same(identities.feature_of(2), identities.feature_of(0)));
}

}  // namespace
}  // namespace mapjoin
