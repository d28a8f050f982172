// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/distributed/regions/dealer.hpp>

namespace mapjoin::distributed {
namespace {

using ::testing::Contains;
using ::testing::Not;

TEST(Dealer, TellsAllRanksOfAPoseThatOnlyFactorsOfOtherSharesConcern) {
  LogShare<2> share;
  share.log.poses = {{0, 10}, {0, 11}, {0, 12}};
  share.log.graph.pose_factors = {{0, 1, {}, PoseMatrix<2>::Identity()}};
  share.poses = {10, 11, 12};
  Values<2> values;
  values.poses.resize(3);
  Table<PoseIndex, std::int32_t> regions(13, 0);
  regions[12] = 1;
  const auto messages = Dealer<2>(regions, 1, share, values).messages(0, 2);
  for (const std::string& message : messages) EXPECT_THAT(decoded<2>(message).poses, Contains(PoseIndex(12)));
  EXPECT_THAT(decoded<2>(messages[1]).poses, Not(Contains(PoseIndex(10))));
}

TEST(Dealer, DealsWhatManyAreMeasuredFromToTheirRegions) {
  LogShare<2> share;
  share.log.poses = {{0, 10}, {0, 11}, {0, 12}};
  share.log.graph.pose_factors = {{0, 1, {}, PoseMatrix<2>::Identity()}, {0, 2, {}, PoseMatrix<2>::Identity()}};
  share.apart.pose_factors = {{10, 13, {}, PoseMatrix<2>::Identity()}};
  share.poses = {10, 11, 12};
  Values<2> values;
  values.poses.resize(3);
  Table<PoseIndex, std::int32_t> regions(14, 1);
  regions[10] = 0;
  const auto messages = Dealer<2>(regions, 1, share, values).messages(0, 2);
  EXPECT_TRUE(decoded<2>(messages[0]).pose_factors.empty());
  EXPECT_EQ(decoded<2>(messages[1]).pose_factors.size(), 3U);
}

}  // namespace
}  // namespace mapjoin::distributed
