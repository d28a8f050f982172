// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/continuation.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <utility>

namespace mapjoin {
namespace {

using testing::largest_difference;

template <typename D>
class ContinuationTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  PartialMap<kDim> composed() const {
    auto joined = join_segments(graph_, {Schedule::kBatch, JoinedState::kAbsolute, {}});
    return std::move(joined.partials.front());
  }

  testing::SmallWorld<kDim> world_ = testing::small_world<kDim>({.poses = 30, .features = 12});
  Split split_ = split(world_.log, {SplitRule::kPoses, 6.0});
  SubmapGraph<kDim> graph_ = submap_graph_of(world_.log, split_, build_local_maps<kDim>(world_.log, split_, {}).value().maps);
  const Gauge<kDim> gauge_{{0}, {}};
};
TYPED_TEST_SUITE(ContinuationTest, testing::Dimensions);

TYPED_TEST(ContinuationTest, AtOneItIsTheJoin) {
  const auto partial = this->composed();
  JoiningSystem<TestFixture::kDim> join(partial, this->gauge_);
  Continuation<TestFixture::kDim> continuation(join, partial, this->gauge_);
  for (const double weight : {1.0, 0.1, 1.0}) {
    continuation.set_weight(weight);
    EXPECT_EQ(std::abs(join.linearise() - partial_map_chi2(partial)) < 1e-12 * partial_map_chi2(partial), weight == 1.0);
  }
}

TYPED_TEST(ContinuationTest, AtZeroItsMinimumIsTheComposedStartWithNothingLeft) {
  const auto partial = this->composed();
  auto random = partial;
  set_to_random(3, random);
  JoiningSystem<TestFixture::kDim> join(random, this->gauge_);
  Continuation<TestFixture::kDim> continuation(join, random, this->gauge_);
  continuation.set_weight(0.0);
  const auto result = minimise_join(join, JoinedState::kRelative, {});
  EXPECT_LT(result.chi2, 1e-9);
  EXPECT_LT(largest_difference(join.estimate(), partial.state), 1e-6);
}

TYPED_TEST(ContinuationTest, GrowsWithTheWeight) {
  auto moved = this->composed();
  for (auto& feature : moved.state.features) feature *= 1.01;
  JoiningSystem<TestFixture::kDim> join(moved, this->gauge_);
  Continuation<TestFixture::kDim> beside(join, moved, this->gauge_);
  double before = -1.0;
  for (const double weight : {0.0, 0.1, 0.5, 1.0}) {
    beside.set_weight(weight);
    const double chi2 = join.linearise();
    EXPECT_GT(chi2, before);
    before = chi2;
  }
}

TYPED_TEST(ContinuationTest, AllStartsMeet) {
  RunOptions options;
  options.split = {SplitRule::kPoses, 6.0};
  const auto optimum = run(this->world_.log, options);
  ASSERT_TRUE(optimum);
  options.schedule = Schedule::kBatch;
  options.state = JoinedState::kRelative;
  options.gradual = true;
  for (const Start start : {Start::kComposed, Start::kZero, Start::kRandom}) {
    for (options.seed = 1; options.seed <= (start == Start::kRandom ? 5u : 1u); ++options.seed) {
      options.start = start;
      const auto result = run(this->world_.log, options);
      ASSERT_TRUE(result) << result.error().message;
      EXPECT_NEAR(result->chi2, optimum->chi2, 1e-9 * optimum->chi2) << to_string(start);
      EXPECT_EQ(result->path.size(), 7u);
    }
  }
}

TYPED_TEST(ContinuationTest, AllStartsMeetWhereFeaturesAloneTieTwoRobots) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = testing::small_world<kDim>({.poses = 24, .features = 24, .sessions = 2});
  RunOptions options;
  options.split = {SplitRule::kPoses, 6.0};
  const auto optimum = run(world.log, options);
  ASSERT_TRUE(optimum);
  options.schedule = Schedule::kBatch;
  options.state = JoinedState::kRelative;
  options.gradual = true;
  options.start = Start::kRandom;
  for (options.seed = 1; options.seed <= 10; ++options.seed) {
    const auto result = run(world.log, options);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_NEAR(result->chi2, optimum->chi2, 1e-9 * optimum->chi2) << options.seed;
  }
}

}  // namespace
}  // namespace mapjoin
