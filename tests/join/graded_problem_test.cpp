// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/graded_problem.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/join/start.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <utility>

namespace mapjoin {
namespace {

using testing::largest_difference;

template <typename D>
class GradedProblemTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  Piece<kDim> composed() const {
    auto joined = join_stretches(network_, {Schedule::kBatch, JoinedState::kAbsolute, {}});
    return std::move(joined.pieces.front());
  }

  testing::SmallWorld<kDim> world_ = testing::small_world<kDim>({.poses = 30, .features = 12});
  Split split_ = split(world_.log, {SplitRule::kPoses, 6.0});
  Network<kDim> network_ = network_of(world_.log, split_, build_local_maps<kDim>(world_.log, split_, {}).value().maps);
  const Gauge<kDim> gauge_{{0}, {}};
};
TYPED_TEST_SUITE(GradedProblemTest, testing::Dimensions);

TYPED_TEST(GradedProblemTest, AtOneItIsTheJoin) {
  const auto piece = this->composed();
  JoinProblem<TestFixture::kDim> join(piece, this->gauge_);
  GradedProblem<TestFixture::kDim> graded(join, piece, this->gauge_);
  for (const double share : {1.0, 0.1, 1.0}) {
    graded.set_share(share);
    EXPECT_EQ(std::abs(join.linearise() - piece_chi2(piece)) < 1e-12 * piece_chi2(piece), share == 1.0);
  }
}

TYPED_TEST(GradedProblemTest, AtZeroItsMinimumIsTheComposedStartWithNothingLeft) {
  const auto piece = this->composed();
  auto random = piece;
  set_to_random(3, random);
  JoinProblem<TestFixture::kDim> join(random, this->gauge_);
  GradedProblem<TestFixture::kDim> graded(join, random, this->gauge_);
  graded.set_share(0.0);
  const auto result = minimise_join(join, JoinedState::kRelative, {});
  EXPECT_LT(result.chi2, 1e-9);
  EXPECT_LT(largest_difference(join.estimate(), piece.state), 1e-6);
}

TYPED_TEST(GradedProblemTest, GrowsWithTheShare) {
  auto moved = this->composed();
  for (auto& feature : moved.state.features) feature *= 1.01;
  JoinProblem<TestFixture::kDim> join(moved, this->gauge_);
  GradedProblem<TestFixture::kDim> beside(join, moved, this->gauge_);
  double before = -1.0;
  for (const double share : {0.0, 0.1, 0.5, 1.0}) {
    beside.set_share(share);
    const double chi2 = join.linearise();
    EXPECT_GT(chi2, before);
    before = chi2;
  }
}

TYPED_TEST(GradedProblemTest, AllStartsMeet) {
  constexpr int kDim = TestFixture::kDim;
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
      const auto result = run<kDim>(this->world_.log, options);
      ASSERT_TRUE(result) << result.error().message;
      EXPECT_NEAR(result->chi2, optimum->chi2, 1e-9 * optimum->chi2) << to_string(start);
      EXPECT_EQ(result->path.size(), 7u);
    }
  }
}

TYPED_TEST(GradedProblemTest, AllStartsMeetWhereFeaturesAloneTieTwoRobots) {
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
    const auto result = run<kDim>(world.log, options);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_NEAR(result->chi2, optimum->chi2, 1e-9 * optimum->chi2) << options.seed;
  }
}

}  // namespace
}  // namespace mapjoin
