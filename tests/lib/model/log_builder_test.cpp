// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/model/log_builder.hpp>
#include <tests/lib/model/built_log_fixture.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::marks;

template <typename D>
class LogBuilderTest : public testing::BuiltLogTest<D> {};
TYPED_TEST_SUITE(LogBuilderTest, testing::Dimensions);

TYPED_TEST(LogBuilderTest, SortsPosesAndTellsOdometryFromClosuresWhateverTheOrderAndDirection) {
  this->edge({0, 40}, {0, 10}, 1);  // a closure: 20 and 30 lie between
  this->edge({0, 30}, {0, 40}, 2);
  this->edge({0, 20}, {0, 10}, 3);  // odometry against its direction
  this->edge({0, 20}, {0, 30}, 4);
  this->edge({0, 10}, {0, 20}, 5);  // a second edge between 10 and 20
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_THAT(log->poses, ElementsAre(PoseId{0, 10}, PoseId{0, 20}, PoseId{0, 30}, PoseId{0, 40}));
  EXPECT_THAT(marks(log->odometry()), ElementsAre(3, 5, 4, 2));
  EXPECT_EQ(log->odometry()[0].base, PoseIndex(1));
  EXPECT_EQ(log->odometry()[0].target, PoseIndex(0));
  EXPECT_THAT(marks(log->closures()), ElementsAre(1));
  EXPECT_EQ(log->repeated_edges, 1);
  ASSERT_EQ(log->sessions.size(), 1u);
  EXPECT_EQ(log->sessions[0].end, PoseIndex(4));
}

TYPED_TEST(LogBuilderTest, StartsASessionWhereOdometryIsMissingAndWhereTheUserStartsOne) {
  this->edge({0, 1}, {0, 2});
  this->edge({0, 3}, {0, 4});
  this->edge({1, 1}, {1, 2});
  this->edge({0, 4}, {1, 1}, 7);  // neighbours in order, but of two sessions
  const auto log = this->finish();
  ASSERT_TRUE(log);
  std::vector<std::pair<PoseIndex, PoseIndex>> sessions;
  for (const auto& s : log->sessions) sessions.emplace_back(s.begin, s.end);
  EXPECT_EQ(sessions, (std::vector<std::pair<PoseIndex, PoseIndex>>{{0, 2}, {2, 4}, {4, 6}}));
  EXPECT_EQ(log->odometry().size(), 3u);
  EXPECT_THAT(marks(log->closures()), ElementsAre(7));
}

TYPED_TEST(LogBuilderTest, SortsObservationsByPoseAndKeepsTheFilesOrderWithin) {
  this->edge({0, 5}, {0, 6});
  this->observe(6, 9, 1);
  this->observe(5, 9, 2);
  this->observe(6, 3, 3);
  this->observe(5, 6, 4);  // feature 6 is not pose 6
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_THAT(marks(log->observations()), ElementsAre(2, 4, 1, 3));
  EXPECT_THAT(log->features, ElementsAre(FeatureId{3}, FeatureId{6}, FeatureId{9}));
  EXPECT_EQ(log->observations()[0].target, FeatureIndex(2));
  EXPECT_EQ(log->poses.size(), 2u);
}

TYPED_TEST(LogBuilderTest, KeepsInitialValuesOnlyWhereEveryoneHasOne) {
  constexpr int kDim = TestFixture::kDim;
  testing::Random random;
  const auto a = random.template pose<kDim>();
  const auto b = random.template pose<kDim>();
  this->builder.add_pose({0, 2}, b);
  this->builder.add_pose({0, 1}, a);
  this->builder.add_feature({4}, Point<kDim>::Ones());
  this->builder.add_feature({5});
  const auto log = this->finish();
  ASSERT_TRUE(log);
  ASSERT_EQ(log->initial.poses.size(), 2u);
  EXPECT_EQ(local(log->initial.poses[1], b).norm(), 0.0);
  EXPECT_TRUE(log->initial.features.empty());
}

TYPED_TEST(LogBuilderTest, FixesAPoseAtTheValueGivenElseAtItsInitialValueElseAtTheOrigin) {
  constexpr int kDim = TestFixture::kDim;
  testing::Random random;
  const auto given = random.template pose<kDim>();
  const auto initial = random.template pose<kDim>();
  this->builder.fix({0, 3});
  this->builder.fix({0, 2}, given);
  this->builder.fix({0, 1});
  this->builder.fix({0, 1});
  this->builder.add_pose({0, 1}, initial);
  this->builder.add_pose({0, 2}, initial);
  this->builder.add_pose({0, 3});
  const auto log = this->finish();
  ASSERT_TRUE(log);
  ASSERT_EQ(log->graph.fixed.size(), 3u);
  EXPECT_EQ(local(log->graph.fixed[0].value, initial).norm(), 0.0);
  EXPECT_EQ(local(log->graph.fixed[1].value, given).norm(), 0.0);
  EXPECT_EQ(local(log->graph.fixed[2].value, Pose<kDim>{}).norm(), 0.0);
}

TYPED_TEST(LogBuilderTest, PriorsComeFromTheWorld) {
  constexpr int kDim = TestFixture::kDim;
  this->builder.add_pose({0, 1});
  this->builder.add_pose_prior({0, 8}, Pose<kDim>{}, PoseMatrix<kDim>::Identity());
  this->builder.add_feature_prior({8}, Point<kDim>::Ones(), PointMatrix<kDim>::Identity());
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_EQ(log->pose_priors()[0].base, kWorld);
  EXPECT_EQ(log->pose_priors()[0].target, PoseIndex(1));
  EXPECT_EQ(log->feature_priors()[0].target, FeatureIndex(0));
}

TYPED_TEST(LogBuilderTest, RefusesALogWithoutPoses) {
  EXPECT_EQ(this->message(), "some.log: the log has no poses");
}

TYPED_TEST(LogBuilderTest, RefusesAnEdgeFromAPoseToItself) {
  this->edge({2, 7}, {2, 7});
  EXPECT_EQ(this->message(), "some.log: an edge leads from pose 7 of session 2 to itself");
}

TYPED_TEST(LogBuilderTest, RefusesStampsOnSomePosesOnly) {
  this->builder.add_stamp({0, 1}, 1000);
  this->builder.add_pose({0, 2});
  EXPECT_THAT(this->message(), HasSubstr("only 1 of 2 poses"));
}

TYPED_TEST(LogBuilderTest, IsLeftEmpty) {
  this->edge({0, 0}, {0, 1});
  this->builder.add_stamp({0, 1}, 1000);
  EXPECT_THAT(this->message(), HasSubstr("only 1 of 2 poses"));
  this->edge({0, 5}, {0, 6});
  const auto log = std::move(this->builder).finish();
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_EQ(log->poses.size(), 2U);
  EXPECT_EQ(log->odometry().size(), 1U);
  EXPECT_EQ(this->message(), "some.log: the log has no poses");
}

TYPED_TEST(LogBuilderTest, RefusesTwoInitialValuesOfOnePose) {
  this->builder.add_pose({0, 1}, Pose<TestFixture::kDim>{});
  this->builder.add_pose({0, 1}, Pose<TestFixture::kDim>{});
  EXPECT_THAT(this->message(), HasSubstr("pose 1 has two initial values"));
}

TYPED_TEST(LogBuilderTest, RefusesAPoseFixedAtTwoPlaces) {
  testing::Random random;
  this->builder.fix({0, 1});
  this->builder.add_pose({0, 1});
  this->builder.fix({0, 1}, random.template pose<TestFixture::kDim>());
  EXPECT_THAT(this->message(), HasSubstr("pose 1 is fixed at two places"));
}

TYPED_TEST(LogBuilderTest, RefusesToFixWhatIsNoPose) {
  this->observe(1, 7);
  this->builder.fix({0, 7});
  EXPECT_EQ(this->message(),
            "some.log: pose 7 is fixed, but the log has no such pose (a feature is not fixed, but held by a prior)");
}

TYPED_TEST(LogBuilderTest, FindsKeysFarApart) {
  const std::uint64_t far = ~std::uint64_t{0};
  this->edge({0, 3}, {0, far - 1});
  this->edge({0, far - 1}, {0, far});
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_EQ(log->odometry().size(), 2u);
  EXPECT_EQ(log->odometry()[1].target, PoseIndex(2));
}

TYPED_TEST(LogBuilderTest, IdentityCovarianceReplacesEveryInformationMatrix) {
  constexpr int kDim = TestFixture::kDim;
  testing::Random random;
  for (const PoseId target : {PoseId{0, 1}, PoseId{0, 2}}) {
    this->builder.add_pose_edge({0, 0}, target, Pose<kDim>{}, random.template information<kPoseDof<kDim>>());
  }
  this->builder.add_observation({0, 0}, {1}, Point<kDim>::Ones(), random.template information<kDim>());
  this->builder.add_pose_prior({0, 0}, Pose<kDim>{}, random.template information<kPoseDof<kDim>>());
  this->builder.add_feature_prior({1}, Point<kDim>::Ones(), random.template information<kDim>());
  auto log = this->finish();
  ASSERT_TRUE(log);
  use_identity_covariance(*log);
  EXPECT_TRUE(log->odometry()[0].information.isIdentity(0.0));
  EXPECT_TRUE(log->closures()[0].information.isIdentity(0.0));
  EXPECT_TRUE(log->observations()[0].information.isIdentity(0.0));
  EXPECT_TRUE(log->pose_priors()[0].information.isIdentity(0.0));
  EXPECT_TRUE(log->feature_priors()[0].information.isIdentity(0.0));
  EXPECT_EQ(log->conventions.covariance, Covariance::kIdentity);
}

TYPED_TEST(LogBuilderTest, RefusesNumbersThatNoReaderWouldTake) {
  constexpr int kDim = TestFixture::kDim;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [](const auto& say) {
    LogBuilder<kDim> builder("some.log");
    builder.add_pose_edge({0, 0}, {0, 1}, Pose<kDim>{}, PoseMatrix<kDim>::Identity());
    builder.add_observation({0, 0}, {7}, Point<kDim>::Zero(), PointMatrix<kDim>::Identity());
    say(builder);
    return testing::error_of(std::move(builder).finish());
  };
  const Pose<kDim> nowhere{Point<kDim>::Constant(kNan), {}};
  PoseMatrix<kDim> W = PoseMatrix<kDim>::Identity();
  EXPECT_EQ(message([&](auto& b) { b.add_pose_edge({0, 1}, {0, 2}, Pose<kDim>{}, W); }), "");
  EXPECT_THAT(message([&](auto& b) {
                b.add_pose_edge({0, 1}, {0, 2}, nowhere, W);
              }),
              HasSubstr("some.log: the edge from pose 1 to pose 2 has a measurement that is not finite"));
  EXPECT_THAT(message([&](auto& b) {
                b.add_pose_prior({0, 1}, nowhere, W);
              }),
              HasSubstr("the prior of pose 1 has a measurement"));
  EXPECT_THAT(message([&](auto& b) {
                b.add_pose_prior({0, 1}, Pose<kDim>{}, W, nowhere.translation);
              }),
              HasSubstr("the prior of pose 1 has a lever that is not finite"));
  EXPECT_THAT(message([&](auto& b) { b.add_pose({0, 1}, nowhere); }), HasSubstr("pose 1 has a value that is not finite"));
  EXPECT_THAT(message([&](auto& b) { b.add_feature({7}, nowhere.translation); }),
              HasSubstr("feature 7 has a value that is not"));
  EXPECT_THAT(message([&](auto& b) { b.fix({0, 1}, nowhere); }), HasSubstr("pose 1 has a value that is not finite"));
  EXPECT_THAT(message([&](auto& b) {
                b.add_observation({0, 1}, {7}, nowhere.translation, PointMatrix<kDim>::Identity());
              }),
              HasSubstr("the observation of feature 7 from pose 1 has a measurement that is not finite"));
  W(0, 1) = 1e-3;
  EXPECT_THAT(message([&](auto& b) {
                b.add_pose_edge({0, 1}, {0, 2}, Pose<kDim>{}, W);
              }),
              HasSubstr("the edge from pose 1 to pose 2 has an information matrix that is not symmetric"));
  W(0, 1) = kNan;
  EXPECT_THAT(message([&](auto& b) { b.add_pose_edge({0, 1}, {0, 2}, Pose<kDim>{}, W); }), HasSubstr("is not finite"));
  EXPECT_THAT(message([&](auto& b) { b.add_feature_prior({7}, Point<kDim>::Zero(), -PointMatrix<kDim>::Identity()); }),
              HasSubstr("the prior of feature 7 has an information matrix that is indefinite"));
}

TYPED_TEST(LogBuilderTest, ASecondFixedPoseNeedsAValue) {
  constexpr int kDim = TestFixture::kDim;
  const auto message = [](const std::vector<std::pair<std::uint64_t, bool>>& fixed, bool has_vertex) {
    LogBuilder<kDim> builder("some.log");
    builder.add_pose_edge({0, 0}, {0, 1}, Pose<kDim>{}, PoseMatrix<kDim>::Identity());
    if (has_vertex) builder.add_pose({0, 1}, Pose<kDim>{});
    for (const auto& [key, has_value] : fixed) {
      builder.fix({0, key}, has_value ? std::optional(Pose<kDim>{}) : std::nullopt);
    }
    return testing::error_of(std::move(builder).finish());
  };
  EXPECT_EQ(message({{0, false}}, false), "");
  EXPECT_EQ(message({{0, false}, {0, false}}, false), "") << "the same pose";
  EXPECT_THAT(message({{0, false}, {1, false}}, false),
              HasSubstr("some.log: pose 1 is fixed beside pose 0, but nothing says where: give it a value"));
  EXPECT_EQ(message({{0, false}, {1, true}}, false), "");
  EXPECT_EQ(message({{0, false}, {1, false}}, true), "");
}

TEST(FindIndex, FindsIdsByTheirPlaceAmongTheNames) {
  const PoseIds consecutive{{0, 5}, {0, 6}, {0, 7}};
  const PoseIds scattered{{0, 5}, {0, 9}, {1, 2}, {1, 9}};
  EXPECT_EQ(IndexOf(consecutive)(PoseId{0, 7}), PoseIndex(2));
  EXPECT_EQ(IndexOf(scattered)(PoseId{1, 9}), PoseIndex(3));
  EXPECT_EQ(IndexOf(scattered)(PoseId{0, 9}), PoseIndex(1));
  for (const PoseId& absent : {PoseId{0, 4}, PoseId{0, 8}, PoseId{1, 5}, PoseId{2, 0}}) {
    EXPECT_EQ(IndexOf(consecutive)(absent), std::nullopt);
    EXPECT_EQ(IndexOf(scattered)(absent), std::nullopt);
  }
  EXPECT_EQ(IndexOf(FeatureIds{})(FeatureId{0}), std::nullopt);
}

TYPED_TEST(LogBuilderTest, TakesAnOrderOfPosesThatNamesEachOnce) {
  const auto in_order = [](const PoseIds& order) {
    LogBuilder<TypeParam::value> builder("some.log");
    for (const std::uint64_t pose : {2u, 0u, 1u}) builder.add_pose({0, pose});
    return std::move(builder).finish(order);
  };
  const auto log = in_order({{0, 1}, {0, 2}, {0, 0}});
  ASSERT_TRUE(log);
  EXPECT_THAT(log->poses, ::testing::ElementsAre(PoseId{0, 1}, PoseId{0, 2}, PoseId{0, 0}));
  for (const PoseIds& order :
       {PoseIds{{0, 1}, {0, 2}}, PoseIds{{0, 1}, {0, 2}, {0, 1}}, PoseIds{{0, 0}, {0, 1}, {0, 2}, {0, 3}}}) {
    EXPECT_THAT(testing::error_of(in_order(order)), ::testing::HasSubstr("does not name each of them once"));
  }
}

}  // namespace
}  // namespace mapjoin
