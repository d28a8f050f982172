// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::largest_difference;
using testing::small_world;

template <typename D>
class StartTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  PartialMap<kDim> partial() const {
    PartialMap<kDim> partial;
    partial.state = world.truth;
    for (const PoseIndex p : indices(world.truth.poses)) partial.poses.push_back(p);
    for (const FeatureIndex f : indices(world.truth.features)) partial.features.push_back(f);
    return partial;
  }
  testing::SmallWorld<kDim> world = small_world<kDim>();
};
TYPED_TEST_SUITE(StartTest, testing::Dimensions);

TYPED_TEST(StartTest, ZeroIsZeroButForThePoseThatHoldsTheMap) {
  auto partial = this->partial();
  const auto first = retract<TestFixture::kDim>({}, PoseVector<TestFixture::kDim>::Ones());
  partial.state.poses[0] = first;
  set_to_zero(partial);
  EXPECT_EQ(partial.state.poses[0].translation, first.translation);
  for (PoseIndex p = 1; p < indices(partial.state.poses).last; ++p) {
    EXPECT_EQ(local(partial.state.poses[p], Pose<TestFixture::kDim>{}).norm(), 0.0);
  }
  for (const auto& feature : partial.state.features) EXPECT_EQ(feature.norm(), 0.0);
}

TYPED_TEST(StartTest, RandomValuesFillTheBoxOfTheComposedStart) {
  constexpr int kDim = TestFixture::kDim;
  auto partial = this->partial();
  Eigen::AlignedBox<double, kDim> box, drawn;
  for (const auto& pose : partial.state.poses) box.extend(pose.translation);
  for (const auto& feature : partial.state.features) box.extend(feature);
  set_to_random(7, partial);
  for (const auto& pose : partial.state.poses) drawn.extend(pose.translation);
  for (const auto& feature : partial.state.features) drawn.extend(feature);
  EXPECT_TRUE(box.contains(drawn));
  EXPECT_GT(drawn.sizes().minCoeff(), 0.7 * box.sizes().minCoeff());
}

TYPED_TEST(StartTest, OneSeedGivesOneStart) {
  auto once = this->partial();
  auto again = this->partial();
  auto another = this->partial();
  set_to_random(7, once);
  set_to_random(7, again);
  set_to_random(8, another);
  EXPECT_EQ(largest_difference(once.state, again.state), 0.0);
  EXPECT_GT(largest_difference(once.state, another.state), 1.0);
}

TYPED_TEST(StartTest, AScheduleThatNeedsNoStartTakesNone) {
  RunOptions options;
  options.start = Start::kZero;
  EXPECT_EQ(options.validate().size(), 1u);
  options.schedule = Schedule::kBatch;
  EXPECT_TRUE(options.validate().empty());
}

TYPED_TEST(StartTest, TheRelativeStateFindsTheOptimumFromZero) {
  constexpr int kDim = TestFixture::kDim;
  const auto optimum = run(this->world.log, RunOptions{});
  ASSERT_TRUE(optimum);
  RunOptions options;
  options.schedule = Schedule::kBatch;
  options.start = Start::kZero;
  options.state = JoinedState::kRelative;
  options.solver.method = Method::kGaussNewton;
  const auto result = solve<kDim>(this->world.log, options);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_NEAR(result->chi2, optimum->chi2, 1e-7 * optimum->chi2);
}

}  // namespace
}  // namespace mapjoin
