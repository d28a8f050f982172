// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/incremental/submap_update.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class PartTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  PartTest() {
    world_.log.graph.fixed.push_back({3, world_.truth.poses[3]});
    world_.log.graph.feature_factors.push_back(
        {kWorld, 7, world_.truth.features[7], PointMatrix<kDim>(100.0 * PointMatrix<kDim>::Identity())});
    split_ = split(world_.log, {SplitRule::kPoses, 6.0});
    maps_ = build_local_maps<kDim>(world_.log, split_, {}).value().maps;
    parts_ = submap_updates_of(world_.log, split_, maps_);
  }

  testing::SmallWorld<kDim> world_ = testing::small_world<kDim>({.poses = 60, .closures = 12, .sessions = 2});
  Split split_;
  std::vector<LocalMap<kDim>> maps_;
  std::vector<SubmapUpdate<kDim>> parts_;
};
TYPED_TEST_SUITE(PartTest, testing::Dimensions);

TYPED_TEST(PartTest, NothingIsSaidOfWhatIsNotYetKnown) {
  std::vector<bool> is_known(this->world_.log.features.size(), false);
  for (const auto& update : this->parts_) {
    if (update.map) {
      for (const Index f : update.map->features) is_known[static_cast<std::size_t>(f)] = true;
    }
    for (const auto& o : update.pose_factors) EXPECT_LE(std::max(o.base, o.target), update.segment->end);
    for (const auto& fixed : update.fixed) EXPECT_LE(fixed.pose, update.segment->end);
    for (const auto& o : update.feature_factors) {
      EXPECT_TRUE(o.base != kWorld || is_known[static_cast<std::size_t>(o.target)]);
      is_known[static_cast<std::size_t>(o.target)] = true;
    }
  }
}

TYPED_TEST(PartTest, AllPartsJoinAsTheirLogDoes) {
  constexpr int kDim = TestFixture::kDim;
  const auto& log = this->world_.log;
  const SubmapGraph<kDim> of_log = submap_graph_of(log, this->split_, this->maps_);
  std::vector<const SubmapUpdate<kDim>*> updates;
  for (const auto& update : this->parts_) updates.push_back(&update);
  const SubmapSet<kDim> set = set_of(updates);
  const SubmapGraph<kDim> of_parts = submap_graph_of_updates(set);
  EXPECT_EQ(of_parts.segments, of_log.segments);
  EXPECT_EQ(of_parts.is_joined, of_log.is_joined);
  EXPECT_EQ(of_parts.is_local, of_log.is_local);
  const auto a = join(of_log, log.poses, log.features, JoinOptions<kDim>{});
  const auto b = join(of_parts, set.poses, set.features, JoinOptions<kDim>{});
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->result.chi2, b->result.chi2, 1e-9 * a->result.chi2);
  EXPECT_EQ(a->dof(), b->dof());
  EXPECT_LT(testing::largest_difference(a->state, b->state), 1e-6);
}

TYPED_TEST(PartTest, ASegmentIsComposedInTheFrameOfItsFirstPose) {
  constexpr int kDim = TestFixture::kDim;
  for (const auto& update : this->parts_) {
    const PartialMap<kDim> partial = composed(update);
    EXPECT_EQ(partial.poses.front(), update.segment->begin);
    EXPECT_EQ(partial.poses.back(), update.segment->end);
    const Pose<kDim>& base = this->world_.truth.pose(update.segment->begin);
    for (std::size_t p = 0; p < partial.poses.size(); ++p) {
      EXPECT_LT(local(partial.state.poses[p], between(base, this->world_.truth.pose(partial.poses[p]))).norm(), 0.5);
    }
    for (std::size_t f = 0; f < partial.features.size(); ++f) {
      const Point<kDim> p_local = transform_into(base, this->world_.truth.feature(partial.features[f]));
      EXPECT_LT((partial.state.features[f] - p_local).norm(), 0.5);
    }
  }
}

}  // namespace
}  // namespace mapjoin
