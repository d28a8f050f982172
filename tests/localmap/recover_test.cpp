// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/recover.hpp>
#include <set>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::largest_difference;
using testing::small_world;

template <typename D>
class RecoverTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  void SetUp() override {
    const auto maps = build_local_maps<kDim>(world.log, parts, {});
    ASSERT_TRUE(maps);
    is_local.assign(world.log.features.size(), false);
    Table<FeatureIndex, std::set<PoseIndex>> seen_in(is_local.size());
    for (const auto& map : maps->maps) {
      for (const FeatureIndex feature : map.features) seen_in[feature].insert(map.base);
    }
    for (const FeatureIndex f : indices(seen_in)) is_local[f] = seen_in[f].size() == 1;
    ASSERT_GT(std::count(is_local.begin(), is_local.end(), true), 0);
  }
  /// The state with interior poses and submap-local features moved far away.
  Values<kDim> forgotten(Values<kDim> state) const {
    for (const PoseIndex p : indices(state.poses)) {
      if (!parts.kept[p]) state.poses[p].translation.setConstant(1e3);
    }
    for (const FeatureIndex f : indices(state.features)) {
      if (is_local[f]) state.features[f].setConstant(-1e3);
    }
    return state;
  }

  testing::SmallWorld<kDim> world = small_world<kDim>({.features = 40, .range = 2.5});
  Split parts = split(world.log, {SplitRule::kPoses, 10.0});
  Table<FeatureIndex, bool> is_local;
};
TYPED_TEST_SUITE(RecoverTest, testing::Dimensions);

TYPED_TEST(RecoverTest, GivesBackTheOptimumWhereWhatIsKeptStandsAtIt) {
  const auto slam = testing::full_slam(this->world.log);
  const auto optimum = slam.optimum(this->world.truth);
  auto state = this->forgotten(optimum);
  recover_interiors(this->world.log, this->parts, this->is_local, {}, state);
  EXPECT_LT(largest_difference(state, optimum), 1e-6);
}

TYPED_TEST(RecoverTest, FindsTheLeastChi2GivenWhatIsHeld) {
  constexpr int kDim = TestFixture::kDim;
  auto state = this->forgotten(this->world.truth);
  recover_interiors(this->world.log, this->parts, this->is_local, {}, state);
  // The dense problem with kept poses and shared features held at the truth.
  auto slam = testing::full_slam(this->world.log);
  std::erase_if(slam.free_poses, [&](PoseIndex pose) { return this->parts.kept[pose]; });
  std::erase_if(slam.free_features, [&](FeatureIndex feature) { return !this->is_local[feature]; });
  const Values<kDim> expected = slam.optimum(this->world.truth);
  EXPECT_LT(largest_difference(state, expected), 1e-6);
}

TYPED_TEST(RecoverTest, BeginsWhereOdometryLeadsFromWhatIsKept) {
  constexpr int kDim = TestFixture::kDim;
  this->world = small_world<kDim>({.features = 40, .range = 2.5, .noise = 0.0});
  auto state = this->world.truth;
  for (const PoseIndex p : indices(state.poses)) {
    if (!this->parts.kept[p]) state.poses[p] = Pose<kDim>{Point<kDim>::Constant(1e3), {}};
  }
  MinimiseOptions one_step;
  one_step.max_iterations = 1;  // without noise, odometry leads to the optimum
  EXPECT_EQ(recover_interiors(this->world.log, this->parts, this->is_local, one_step, state), 0U);
  EXPECT_LT(largest_difference(state, this->world.truth), 1e-9);
}

TYPED_TEST(RecoverTest, CountsTheMapsWhoseInteriorsDidNotConverge) {
  auto state = this->world.truth;
  EXPECT_EQ(recover_interiors(this->world.log, this->parts, this->is_local, {}, state), 0U);
  MinimiseOptions one_step;
  one_step.max_iterations = 1;
  EXPECT_GT(recover_interiors(this->world.log, this->parts, this->is_local, one_step, state), 0U);
}

TYPED_TEST(RecoverTest, LeavesWhatIsKeptUntouched) {
  auto state = this->world.truth;
  recover_interiors(this->world.log, this->parts, this->is_local, {}, state);
  for (const PoseIndex p : indices(state.poses)) {
    if (!this->parts.kept[p]) continue;
    EXPECT_EQ(local(state.poses[p], this->world.truth.poses[p]).norm(), 0.0);
  }
  for (const FeatureIndex f : indices(state.features)) {
    if (this->is_local[f]) continue;
    EXPECT_EQ(state.features[f], this->world.truth.features[f]);
  }
}

}  // namespace
}  // namespace mapjoin
