// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/schedule.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_map_set.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class WatchJoinTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static MapSet<kDim> maps() {
    return testing::small_map_set(testing::small_world<kDim>({.poses = 60, .features = 40}).log, 6.0);
  }
  /// The first `count` maps, with the closures among their poses.
  static MapSet<kDim> first(MapSet<kDim> set, std::size_t count) {
    set.graph.submaps.resize(count);
    set.stretches.resize(count);
    const Index end = set.stretches.back().end;
    set.poses.resize(static_cast<std::size_t>(end) + 1);
    std::erase_if(set.graph.pose_factors, [&](const auto& o) { return std::max(o.base, o.target) > end; });
    std::vector<Index> place(set.features.size(), -1);
    std::vector<FeatureId> seen;
    for (auto& map : set.graph.submaps) {
      for (Index& feature : map.features) {
        Index& at = place[static_cast<std::size_t>(feature)];
        if (at < 0) {
          at = static_cast<Index>(seen.size());
          seen.push_back(set.features[static_cast<std::size_t>(feature)]);
        }
        feature = at;
      }
    }
    set.features = seen;
    return set;
  }
};
TYPED_TEST_SUITE(WatchJoinTest, testing::Dimensions);

TYPED_TEST(WatchJoinTest, IsNearTheOptimumOfTheFirstMapsAtEveryStop) {
  constexpr int kDim = TestFixture::kDim;
  const MapSet<kDim> set = this->maps();
  const Network<kDim> network = network_of(set);
  for (const std::size_t at_once : {1u, 3u}) {
    std::vector<std::size_t> stops;
    watch_join<kDim>(network, at_once, [&](std::size_t stretches, const JoinedPieces<kDim>& joined) {
      stops.push_back(stretches);
      if (stretches == set.graph.submaps.size()) return;  // not yet solved
      ASSERT_EQ(joined.pieces.size(), 1U);
      const MapSet<kDim> part = this->first(set, stretches);
      const auto whole = join(network_of(part), part.poses, part.features, JoinOptions<kDim>{}).value();
      const double chi2 = piece_chi2(joined.pieces.front());
      EXPECT_LT(chi2, 1.02 * whole.result.chi2 + 0.5) << stretches;
      EXPECT_GT(chi2, 0.98 * whole.result.chi2 - 0.5) << stretches;
    });
    std::vector<std::size_t> expected;
    for (std::size_t k = at_once; k < set.graph.submaps.size() + at_once; k += at_once)
      expected.push_back(std::min(k, set.graph.submaps.size()));
    EXPECT_EQ(stops, expected);
  }
}

TYPED_TEST(WatchJoinTest, OneByOneIsTheSequentialSchedule) {
  constexpr int kDim = TestFixture::kDim;
  const MapSet<kDim> set = this->maps();
  const Network<kDim> network = network_of(set);
  const ScheduleOptions sequential{Schedule::kSequential, JoinedState::kAbsolute, nullptr};
  const auto joined = join_stretches(network, sequential);
  State<kDim> last;
  watch_join<kDim>(network, 1, [&](std::size_t, const JoinedPieces<kDim>& so_far) { last = so_far.pieces.front().state; });
  ASSERT_EQ(last.poses.size(), joined.pieces.front().state.poses.size());
  for (std::size_t p = 0; p < last.poses.size(); ++p) {
    EXPECT_EQ(last.poses[p].translation, joined.pieces.front().state.poses[p].translation);
  }
}

TYPED_TEST(WatchJoinTest, CountsWhatIsDoneToTheEnd) {
  constexpr int kDim = TestFixture::kDim;
  const MapSet<kDim> set = this->maps();
  for (const std::size_t at_once : {1u, 4u}) {
    std::size_t last = 0;
    std::size_t all = 1;
    watch_join<kDim>(network_of(set), at_once, nullptr, [&](std::size_t done, std::size_t to_do) {
      last = done;
      all = to_do;
    });
    EXPECT_EQ(last, all);
  }
}

}  // namespace
}  // namespace mapjoin
