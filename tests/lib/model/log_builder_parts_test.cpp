// SPDX-License-Identifier: BSD-3-Clause
// Logs that are appended to a builder, and what is taken out of one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <mapjoin/model/log_builder.hpp>
#include <stdexcept>
#include <tests/lib/model/built_log_fixture.hpp>
#include <tests/support/dimensions.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using testing::marks;

template <typename D>
class LogBuilderPartsTest : public testing::BuiltLogTest<D> {};
TYPED_TEST_SUITE(LogBuilderPartsTest, testing::Dimensions);

TYPED_TEST(LogBuilderPartsTest, AppendsALogAsItIsInSessionsOfItsOwn) {
  constexpr int kDim = TestFixture::kDim;
  this->edge({0, 0}, {0, 1}, 1);
  this->edge({3, 0}, {3, 1}, 2);
  this->edge({0, 0}, {3, 1}, 3);
  this->builder.add_observation({0, 1}, {7}, Point<kDim>::Ones(), PointMatrix<kDim>::Identity());
  this->builder.add_pose_prior({0, 1}, Pose<kDim>{}, PoseMatrix<kDim>::Identity(), Point<kDim>::Ones());
  Log<kDim> log = this->finish().value();
  const auto closure = std::ranges::find(log.graph.pose_factors, log.closures().front().measured, &PoseFactor<kDim>::measured);
  closure->loss = Loss::truncated(9.0);
  LogBuilder<kDim> sessions("sessions");
  sessions.append(log, 5);
  const Log<kDim> appended = std::move(sessions).finish().value();
  EXPECT_THAT(appended.poses, ElementsAre(PoseId{5, 0}, PoseId{5, 1}, PoseId{8, 0}, PoseId{8, 1}));
  EXPECT_EQ(appended.features, log.features);
  EXPECT_THAT(marks(appended.edges()), ElementsAre(1, 2, 3));
  EXPECT_EQ(appended.closures().front().loss, Loss::truncated(9.0));
  EXPECT_EQ(appended.pose_priors().front().lever, Point<kDim>::Ones());
  EXPECT_EQ(appended.observations().front().measured, Point<kDim>::Ones());
  constexpr auto kLast = std::numeric_limits<std::uint32_t>::max();
  EXPECT_NO_THROW(LogBuilder<kDim>("last").append(log, kLast - 3));
  EXPECT_THROW(LogBuilder<kDim>("too far").append(log, kLast - 2), std::out_of_range);
}

TYPED_TEST(LogBuilderPartsTest, AddsTheRepairsOfALogThatIsAppended) {
  constexpr int kDim = TestFixture::kDim;
  this->edge({0, 0}, {0, 1});
  this->builder.add_repairs({.symmetrised = 1, .largest_asymmetry = 1e-7, .indefinite = 2, .missing = 3});
  const Log<kDim> log = this->finish().value();
  LogBuilder<kDim> both("both", without_repairs(log.conventions));
  both.append(log);
  both.append(log, 1);
  const MatrixRepairs repairs = std::move(both).finish()->conventions.repairs;
  EXPECT_EQ(repairs.symmetrised, 2);
  EXPECT_EQ(repairs.largest_asymmetry, 1e-7);
  EXPECT_EQ(repairs.indefinite, 4);
  EXPECT_EQ(repairs.missing, 6);
}

TYPED_TEST(LogBuilderPartsTest, TakesWhatIsUndeclaredOutWithItsTimeStamps) {
  constexpr int kDim = TestFixture::kDim;
  for (const std::uint64_t pose : {1u, 2u}) this->builder.add_pose({0, pose}, Pose<kDim>{});
  this->edge({0, 0}, {0, 1}, 5);
  this->edge({0, 1}, {0, 2}, 6);
  for (std::int64_t pose = 0; pose < 3; ++pose) this->builder.add_stamp({0, static_cast<std::uint64_t>(pose)}, 100 + pose);
  const LeftOut<kDim> out = this->builder.take_undeclared();
  ASSERT_EQ(out.factor_count(), 1);
  EXPECT_EQ(out.edges.front().base, (PoseId{0, 0}));
  const auto log = this->finish();
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_THAT(log->poses, ElementsAre(PoseId{0, 1}, PoseId{0, 2}));
  EXPECT_THAT(marks(log->odometry()), ElementsAre(6));
  EXPECT_THAT(log->stamps_ns, ElementsAre(101, 102));
}

TYPED_TEST(LogBuilderPartsTest, ForgetsWhatNoFactorNames) {
  constexpr int kDim = TestFixture::kDim;
  for (const std::uint64_t pose : {0u, 1u, 7u}) this->builder.add_pose({0, pose}, Pose<kDim>{});
  this->builder.add_feature({9}, Point<kDim>::Ones());
  this->builder.add_feature({8}, Point<kDim>::Ones());
  this->builder.add_feature_prior({8}, Point<kDim>::Ones(), PointMatrix<kDim>::Identity());
  for (const std::uint64_t pose : {0u, 6u, 7u}) this->builder.fix({0, pose});
  this->edge({0, 0}, {0, 1});
  this->builder.forget_loose();
  const auto log = this->finish();
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_THAT(log->poses, ElementsAre(PoseId{0, 0}, PoseId{0, 1}));
  EXPECT_THAT(log->features, ElementsAre(FeatureId{8}));
  EXPECT_EQ(log->initial.poses.size(), 2u);
  EXPECT_EQ(log->initial.features.size(), 1u);
  EXPECT_EQ(log->graph.fixed.size(), 1u);
}

TYPED_TEST(LogBuilderPartsTest, ForgetsWhichOtherPosesAreFixedAtValuesToCome) {
  constexpr int kDim = TestFixture::kDim;
  this->builder.add_pose({0, 2}, Pose<kDim>{});
  for (const std::uint64_t pose : {1u, 0u, 2u}) this->builder.fix({0, pose});
  this->edge({0, 0}, {0, 1});
  this->edge({0, 1}, {0, 2});
  this->builder.forget_loose();
  const auto log = this->finish();
  ASSERT_TRUE(log) << log.error().message;
  ASSERT_EQ(log->graph.fixed.size(), 2u);
  EXPECT_EQ(log->graph.fixed[0].pose, PoseIndex(1));
}

}  // namespace
}  // namespace mapjoin
