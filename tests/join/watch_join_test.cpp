// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/schedule.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class WatchJoinTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static SubmapSet<kDim> maps() {
    return testing::small_submap_set(testing::small_world<kDim>({.poses = 60, .features = 40}).log, 6.0);
  }
  /// The first `count` maps, with the closures among their poses.
  static SubmapSet<kDim> first(SubmapSet<kDim> set, std::size_t count) {
    set.graph.submaps.resize(count);
    set.segments.resize(count);
    const PoseIndex end = set.segments.back().end;
    set.poses.resize((end + 1).position());
    std::erase_if(set.graph.pose_factors, [&](const auto& o) { return std::max(o.base, o.target) > end; });
    Table<FeatureIndex, FeatureIndex> place(set.features.size(), FeatureIndex(-1));
    FeatureIds seen;
    for (auto& map : set.graph.submaps) {
      for (FeatureIndex& feature : map.features) {
        FeatureIndex& at = place[feature];
        if (at < 0) {
          at = indices(seen).last;
          seen.push_back(set.features[feature]);
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
  const SubmapSet<kDim> set = this->maps();
  const SubmapGraph<kDim> graph = submap_graph_of(set);
  for (const std::size_t at_once : {1u, 3u}) {
    std::vector<std::size_t> stops;
    watch_join<kDim>(graph, at_once, [&](std::size_t segments, const JoinedPartialMaps<kDim>& joined) {
      stops.push_back(segments);
      if (segments == set.graph.submaps.size()) return;  // the last join is not solved yet
      ASSERT_EQ(joined.partials.size(), 1U);
      const SubmapSet<kDim> part = this->first(set, segments);
      const auto joined_map = join(submap_graph_of(part), part.poses, part.features, JoinOptions<kDim>{}).value();
      const double chi2 = partial_map_chi2(joined.partials.front());
      EXPECT_LT(chi2, 1.02 * joined_map.result.chi2 + 0.5) << segments;
      EXPECT_GT(chi2, 0.98 * joined_map.result.chi2 - 0.5) << segments;
    });
    std::vector<std::size_t> expected;
    for (std::size_t k = at_once; k < set.graph.submaps.size() + at_once; k += at_once)
      expected.push_back(std::min(k, set.graph.submaps.size()));
    EXPECT_EQ(stops, expected);
  }
}

TYPED_TEST(WatchJoinTest, OneByOneIsTheSequentialSchedule) {
  constexpr int kDim = TestFixture::kDim;
  const SubmapSet<kDim> set = this->maps();
  const SubmapGraph<kDim> graph = submap_graph_of(set);
  const ScheduleOptions sequential{Schedule::kSequential, JoinedState::kAbsolute, nullptr};
  const auto joined = join_segments(graph, sequential);
  Values<kDim> last;
  watch_join<kDim>(graph, 1, [&](std::size_t, const JoinedPartialMaps<kDim>& so_far) { last = so_far.partials.front().state; });
  ASSERT_EQ(last.poses.size(), joined.partials.front().state.poses.size());
  for (const PoseIndex p : indices(last.poses)) {
    EXPECT_EQ(last.poses[p].translation, joined.partials.front().state.poses[p].translation);
  }
}

TYPED_TEST(WatchJoinTest, CountsWhatIsDoneToTheEnd) {
  constexpr int kDim = TestFixture::kDim;
  const SubmapSet<kDim> set = this->maps();
  for (const std::size_t at_once : {1u, 4u}) {
    std::size_t last = 0;
    std::size_t all = 1;
    watch_join<kDim>(submap_graph_of(set), at_once, nullptr, [&](std::size_t done, std::size_t to_do) {
      last = done;
      all = to_do;
    });
    EXPECT_EQ(last, all);
  }
}

}  // namespace
}  // namespace mapjoin
