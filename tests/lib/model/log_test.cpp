// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/model/log_builder.hpp>
#include <stdexcept>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <typename D>
class LogTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Two steps, their closure, an observation from the last pose, a prior of the middle one, the first one fixed.
  static Log<kDim> small() {
    const PoseMatrix<kDim> W = PoseMatrix<kDim>::Identity();
    LogBuilder<kDim> builder("robot.g2o");
    for (std::uint64_t pose = 0; pose < 3; ++pose) {
      builder.add_pose({0, pose}, Pose<kDim>{});
      builder.add_stamp({0, pose}, 1000 + static_cast<std::int64_t>(pose));
    }
    builder.add_feature({5}, Point<kDim>::Ones());
    builder.add_pose_edge({0, 0}, {0, 1}, {}, W);
    builder.add_pose_edge({0, 1}, {0, 2}, {}, W);
    builder.add_pose_edge({0, 0}, {0, 2}, {}, W);
    builder.add_pose_prior({0, 1}, {}, W);
    builder.add_observation({0, 2}, {5}, Point<kDim>::Ones(), PointMatrix<kDim>::Identity());
    builder.fix({0, 0});
    return std::move(builder).finish().value();
  }
  /// The fault of the small log once `change` has changed it; empty if there is none.
  template <typename Change>
  static std::string fault_after(Change&& change) {
    Log<kDim> log = small();
    change(log);
    return testing::error_of(check_invariants(log));
  }
};
TYPED_TEST_SUITE(LogTest, testing::Dimensions);

TYPED_TEST(LogTest, IsInflatedByKind) {
  auto log = TestFixture::small();
  inflate({.closures = 2.0, .odometry = 4.0, .observations = 8.0, .priors = 16.0, .maps = 32.0}, log);
  for (const auto& step : log.odometry()) EXPECT_EQ(step.information(0, 0), 1.0 / 16.0);
  EXPECT_EQ(log.closures()[0].information(0, 0), 0.25);
  EXPECT_EQ(log.observations()[0].information(0, 0), 1.0 / 64.0);
  EXPECT_EQ(log.pose_priors()[0].information(0, 0), 1.0 / 256.0);
  inflate({.observations = 2.0}, log);
  EXPECT_EQ(log.observations()[0].information(0, 0), 1.0 / 256.0);
  EXPECT_EQ(log.conventions.inflation.observations, 16.0);
  use_identity_covariance(log);
  EXPECT_EQ(log.conventions.inflation, Inflation{});
}

TYPED_TEST(LogTest, IsInflatedByWhatTheCommandTakes) {
  auto log = TestFixture::small();
  for (const double wrong : {0.0, -2.0, 1e7, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(inflate({.odometry = wrong}, log), std::invalid_argument) << wrong;
  }
}

TYPED_TEST(LogTest, IsHeldByFixedPosesAndByPriors) {
  auto log = this->small();
  log.graph.pose_factors.pop_back();
  EXPECT_TRUE(log.is_held()) << "by the fixed pose";
  log.graph.fixed.clear();
  EXPECT_FALSE(log.is_held());
  auto by_pose = log;
  by_pose.graph.pose_factors.push_back({kWorld, 1, {}, PoseMatrix<TypeParam::value>::Identity()});
  EXPECT_TRUE(by_pose.is_held());
  auto by_feature = log;
  by_feature.graph.feature_factors.push_back(
      {kWorld, 0, Point<TypeParam::value>::Ones(), PointMatrix<TypeParam::value>::Identity()});
  EXPECT_TRUE(by_feature.is_held());
}

TYPED_TEST(LogTest, ThatIsBuiltHasItsInvariants) {
  EXPECT_EQ(this->fault_after([](auto&) {}), "");
  EXPECT_EQ(testing::error_of(check_invariants(Log<TypeParam::value>{})), "there are no poses");
}

TYPED_TEST(LogTest, MayNotNameAPoseOrFeatureThatItDoesNotHave) {
  const std::string why = ", names a pose or feature that is not there";
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.pose_factors[2].target = 9; }),
            "robot.g2o: pose factor 2, from pose 0 to index 9" + why);
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.pose_factors[1].base = -7; }),
            "robot.g2o: pose factor 1, from index -7 to pose 2" + why);
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.pose_factors[3].target = kWorld; }),
            "robot.g2o: pose factor 3, from the World to index -1" + why);
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.feature_factors[0].target = 1; }),
            "robot.g2o: feature factor 0, from pose 2 to index 1" + why);
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.feature_factors[0].base = 3; }),
            "robot.g2o: feature factor 0, from index 3 to feature 5" + why);
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.fixed[0].pose = 3; }),
            "robot.g2o: index 3 is fixed, but the log has no such pose");
}

TYPED_TEST(LogTest, NamesEachPoseAndFeatureOnce) {
  EXPECT_EQ(this->fault_after([](auto& log) { log.poses[1] = log.poses[0]; }), "robot.g2o: it names pose 0 twice");
  const auto with_feature = [&](std::uint64_t key) {
    return this->fault_after([&](auto& log) {
      log.features.push_back({key});
      log.initial.features.push_back(log.initial.features[0]);
    });
  };
  EXPECT_EQ(with_feature(6), "");
  EXPECT_EQ(with_feature(5), "robot.g2o: it names feature 5 twice");
}

TYPED_TEST(LogTest, HasNumbersThatItsBuilderTakes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto factor = [&](const auto& change) {
    return this->fault_after([&](auto& log) { change(log.graph.pose_factors[0]); });
  };
  const std::string first = "robot.g2o: pose factor 0, from pose 0 to pose 1, ";
  EXPECT_EQ(factor([&](auto& f) { f.measured.translation[0] = nan; }),
            first + "has a measurement that is not finite, or no rotation");
  EXPECT_EQ(factor([&](auto& f) { f.information(0, 0) = nan; }), first + "has an information matrix that is not finite");
  EXPECT_THAT(factor([&](auto& f) { f.information(0, 1) += 0.5; }),
              ::testing::StartsWith(first + "has an information matrix that "
                                            "is not symmetric"));
  EXPECT_THAT(factor([&](auto& f) { f.information(0, 0) = -5.0; }),
              ::testing::StartsWith(first + "has an information matrix that is indefinite"));
  EXPECT_EQ(factor([&](auto& f) { f.lever[0] = 1.0; }), first + "has a lever, which only priors have");
  EXPECT_EQ(factor([&](auto& f) { f.loss = Loss::dropped(); }), "") << "as searches drop factors";
  EXPECT_THAT(this->fault_after([&](auto& log) { log.graph.feature_factors[0].measured[1] = nan; }),
              ::testing::HasSubstr("feature factor 0, from pose 2 to feature 5, has a measurement that is not finite"));
  EXPECT_EQ(this->fault_after([&](auto& log) { log.graph.fixed[0].value.translation[0] = nan; }),
            "robot.g2o: pose 0 is fixed at a value that is not finite, or no rotation");
  EXPECT_EQ(this->fault_after([&](auto& log) { log.initial.poses[1].translation[0] = nan; }),
            "robot.g2o: pose 1 has a value that is not finite, or no rotation");
  EXPECT_EQ(this->fault_after([&](auto& log) { log.initial.features[0][0] = nan; }),
            "robot.g2o: feature 5 has a value that is not finite, or no rotation");
}

TYPED_TEST(LogTest, HasItsFactorsInOrder) {
  EXPECT_EQ(this->fault_after([](auto& log) { std::swap(log.graph.pose_factors[2], log.graph.pose_factors[3]); }),
            "robot.g2o: pose factor 3, from pose 0 to pose 2, is out of order: put_in_order() sorts the factors");
  const auto see_from_the_first = [](auto& log) {
    log.graph.feature_factors.push_back(log.graph.feature_factors[0]);
    log.graph.feature_factors[1].base = 0;
  };
  EXPECT_EQ(this->fault_after(see_from_the_first),
            "robot.g2o: feature factor 1, from pose 0 to feature 5, is out of order: put_in_order() sorts the factors");
  const auto sorted = [&](auto& log) {
    see_from_the_first(log);
    put_in_order(log);
  };
  EXPECT_EQ(this->fault_after(sorted), "");
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.pose_factors[2].base = 2; }),
            "robot.g2o: pose factor 2, from pose 2 to pose 2, leads from a pose to itself");
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.fixed.push_back(log.graph.fixed[0]); }),
            "robot.g2o: pose 0 is fixed twice");
  const auto fix_backwards = [](auto& log) {
    log.graph.fixed.insert(log.graph.fixed.begin(), log.graph.fixed[0]);
    log.graph.fixed[0].pose = 2;
  };
  EXPECT_EQ(this->fault_after(fix_backwards), "robot.g2o: its fixed poses are out of order: put_in_order() sorts them");
  const auto fixed_in_order = [&](auto& log) {
    fix_backwards(log);
    put_in_order(log);
  };
  EXPECT_EQ(this->fault_after(fixed_in_order), "");
}

TYPED_TEST(LogTest, HasEveryPoseInOneSession) {
  const std::string wrong = "robot.g2o: its sessions do not hold every pose once, in order: put_in_order() finds them";
  EXPECT_EQ(this->fault_after([](auto& log) { log.sessions.clear(); }), wrong);
  EXPECT_EQ(this->fault_after([](auto& log) { log.sessions = {{0, 2}}; }), wrong);
  EXPECT_EQ(this->fault_after([](auto& log) { log.sessions = {{0, 4}}; }), wrong);
  EXPECT_EQ(this->fault_after([](auto& log) { log.sessions = {{0, 2}, {1, 3}}; }), wrong);
  EXPECT_EQ(this->fault_after([](auto& log) { log.sessions = {{0, 2}, {2, 2}, {2, 3}}; }), wrong);
}

TYPED_TEST(LogTest, HasStampsAndInitialValuesOfAllOrOfNone) {
  EXPECT_EQ(this->fault_after([](auto& log) { log.stamps_ns.pop_back(); }), "robot.g2o: it has 2 time stamps of poses for 3");
  EXPECT_EQ(this->fault_after([](auto& log) { log.initial.poses.pop_back(); }),
            "robot.g2o: it has 2 initial values of poses for 3");
  EXPECT_EQ(this->fault_after([](auto& log) { log.initial.features.resize(2); }),
            "robot.g2o: it has 2 initial values of features for 1");
  const auto bare = [](auto& log) {
    log.stamps_ns.clear();
    log.initial = {};
  };
  EXPECT_EQ(this->fault_after(bare), "");
}

TYPED_TEST(LogTest, HasNoLocalMaps) {
  EXPECT_EQ(this->fault_after([](auto& log) { log.graph.submaps.emplace_back(); }),
            "robot.g2o: a log has no local maps: a SubmapSet has");
}

}  // namespace
}  // namespace mapjoin
