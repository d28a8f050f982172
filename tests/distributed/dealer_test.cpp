// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/distributed/regions/dealer.hpp>

namespace mapjoin::distributed {
namespace {

using ::testing::Contains;
using ::testing::Not;

PoseFactor<2> edge(PoseIndex base, PoseIndex target) {
  return {base, target, {}, PoseMatrix<2>::Identity()};
}

/// The messages of a share of the poses 10, 11 and 12, with edges of its log and others, to one region of each of two ranks.
std::vector<std::string> dealt(const std::vector<PoseFactor<2>>& of_log, const std::vector<PoseFactor<2>>& apart,
                               const Table<PoseIndex, std::int32_t>& regions) {
  LogShare<2> share;
  share.log.poses = {{0, 10}, {0, 11}, {0, 12}};
  share.log.graph.pose_factors = of_log;
  share.apart.pose_factors = apart;
  share.poses = {10, 11, 12};
  Values<2> values;
  values.poses.resize(3);
  return Dealer<2>(regions, 1, share, values).messages(0, 2);
}

TEST(Dealer, TellsAllRanksOfAPoseThatOnlyFactorsOfOtherSharesConcern) {
  Table<PoseIndex, std::int32_t> regions(13, 0);
  regions[12] = 1;
  const auto messages = dealt({edge(0, 1)}, {}, regions);
  for (const std::string& message : messages) EXPECT_THAT(decoded<2>(message).poses, Contains(PoseIndex(12)));
  EXPECT_THAT(decoded<2>(messages[1]).poses, Not(Contains(PoseIndex(10))));
}

TEST(Dealer, DealsWhatManyAreMeasuredFromToTheirRegions) {
  Table<PoseIndex, std::int32_t> regions(14, 1);
  regions[10] = 0;
  const auto messages = dealt({edge(0, 1), edge(0, 2)}, {edge(10, 13)}, regions);
  EXPECT_TRUE(decoded<2>(messages[0]).pose_factors.empty());
  EXPECT_EQ(decoded<2>(messages[1]).pose_factors.size(), 3U);
}

}  // namespace
}  // namespace mapjoin::distributed
