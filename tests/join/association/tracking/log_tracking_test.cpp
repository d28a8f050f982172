// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <map>
#include <mapjoin/join/association/tracking/log_tracking.hpp>
#include <mapjoin/join/association/tracking/sighting_density.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/wood.hpp>

namespace mapjoin {
namespace {

template <typename D>
class LogTrackingTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  std::vector<Tracked> tracked(const AssociationOptions& options) { return track_log(log, parts, options, density, {}); }

  Log<kDim> log = testing::wood<kDim>(1).log;
  Split parts = split(log, {SplitRule::kPoses, 30.0});
  NeighbourDensity<kDim> density = density_of<kDim>(log.observations(), {});
};
TYPED_TEST_SUITE(LogTrackingTest, testing::Dimensions);

TYPED_TEST(LogTrackingTest, FollowsFeaturesWithinTheirSegmentsOnly) {
  const std::vector<Tracked> tracked = this->tracked({});
  ASSERT_EQ(tracked.size(), this->log.observations().size());
  std::map<std::size_t, FeatureIndex> name_of;
  std::map<std::size_t, std::size_t> segment_of;
  std::size_t next = 0;
  std::size_t right = 0;
  for (std::size_t k = 0; k < this->parts.segments.size(); ++k) {
    for (const auto& seen : observations_of(this->log, this->parts.segments[k])) {
      const std::size_t feature = tracked[next++].feature;
      EXPECT_EQ(segment_of.try_emplace(feature, k).first->second, k);
      right += name_of.try_emplace(feature, seen.target).first->second == seen.target ? 1U : 0U;
    }
  }
  EXPECT_EQ(segment_of.rbegin()->first, segment_of.size() - 1);  // numbered without gaps
  EXPECT_LT(segment_of.size(), tracked.size() / 2);
  EXPECT_GE(right, tracked.size() * 99 / 100);
}

TYPED_TEST(LogTrackingTest, TakesNoLowerDensityThanThatOfWhatIsSeenAtOnce) {
  const double seen_at_once = this->density.overall();
  this->tracked({});
  EXPECT_GE(this->density.overall(), seen_at_once);
}

}  // namespace
}  // namespace mapjoin
