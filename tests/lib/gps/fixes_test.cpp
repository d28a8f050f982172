// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <numbers>
#include <stdexcept>
#include <tests/support/error_of.hpp>
#include <utility>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr double kQuarter = std::numbers::pi / 2.0;

/// A log of poses 0 to 4, a second apart. Steps go 2 m ahead, then turn left by a quarter; the last one, from pose 2 to pose 3,
/// is stored backwards. No odometry leads to pose 4, which sees the same feature as pose 3.
Log<2> log_of(std::uint32_t session = 0, bool has_stamps = true) {
  LogBuilder<2> builder("log.g2o");
  const Pose<2> step{Point<2>(2.0, 0.0), Rotation<2>(kQuarter)};
  for (std::uint64_t k = 0; k < 5; ++k) {
    builder.add_pose({session, k});
    if (has_stamps) builder.add_stamp({session, k}, kSecond * static_cast<std::int64_t>(k));
  }
  builder.add_pose_edge({session, 0}, {session, 1}, step, PoseMatrix<2>::Identity());
  builder.add_pose_edge({session, 1}, {session, 2}, step, PoseMatrix<2>::Identity());
  builder.add_pose_edge({session, 3}, {session, 2}, inverse(step), PoseMatrix<2>::Identity());
  builder.add_observation({session, 3}, {7}, Point<2>(1.0, 0.0), PointMatrix<2>::Identity());
  builder.add_observation({session, 4}, {7}, Point<2>(0.0, 0.0), PointMatrix<2>::Identity());
  builder.fix({session, 0});
  return std::move(builder).finish().value();
}

GpsFix fix_at(double seconds, std::size_t line = 2) {
  return {line, static_cast<std::int64_t>(seconds * 1e9), std::nullopt, {50.0, 8.0, 100.0}, {2.0, 0.5, 1.0}};
}

GpsFixes fixes_of(std::vector<GpsFix> fixes) {
  return {"fixes.csv", true, std::move(fixes)};
}

TEST(AttachFixes, AFixAtTheTimeOfAPoseIsAPriorOfItsAntenna) {
  Log<2> log = log_of();
  const auto attached = attach_fixes(fixes_of({fix_at(2.0, 9)}), {.lever = Point<3>(0.3, -0.2, 1.0)}, log).value();
  ASSERT_EQ(log.pose_priors().size(), 1U);
  const PoseFactor<2>& prior = log.pose_priors()[0];
  EXPECT_EQ(prior.target, PoseIndex(2));
  EXPECT_EQ(prior.lever, Point<2>(0.3, -0.2));
  EXPECT_LT(prior.measured.translation.norm(), 1e-8) << "the only fix is the origin";
  EXPECT_NEAR(prior.information(0, 0), 0.25, 1e-12);
  EXPECT_NEAR(prior.information(1, 1), 4.0, 1e-12);
  EXPECT_EQ(prior.information.row(2).norm(), 0.0);
  EXPECT_EQ(attached.lines, std::vector<std::size_t>{9});
}

TEST(AttachFixes, InThePlaneAFixOnAHillIsWhereItsLatitudeAndLongitudeAre) {
  Log<2> log = log_of();
  GpsFix low = fix_at(1.0);
  low.place.longitude += 0.07;
  GpsFix high = low;
  high.when = 2 * kSecond;
  high.place.height += 500.0;
  const auto attached = attach_fixes(fixes_of({fix_at(0.0), low, high}), {}, log).value();
  const auto priors = log.pose_priors();
  ASSERT_EQ(priors.size(), 3U);
  EXPECT_EQ(priors[1].measured.translation, priors[2].measured.translation);
  for (const auto& [prior, fix] : {std::pair{priors[0], fix_at(0.0)}, {priors[1], low}}) {
    const GeographicPoint place = attached.frame.to_geographic(prior.measured.translation);
    EXPECT_NEAR(place.latitude, fix.place.latitude, 1e-12);
    EXPECT_NEAR(place.longitude, fix.place.longitude, 1e-12);
  }
}

TEST(AttachFixes, BetweenTwoPosesTheLeverFollowsOdometryFromTheNearerOne) {
  Log<2> log = log_of();
  const Point<2> lever(1.0, 0.0);
  ASSERT_TRUE(
      attach_fixes(fixes_of({fix_at(0.25), fix_at(0.75), fix_at(2.25), fix_at(2.75)}), {.lever = {1.0, 0.0, 0.0}}, log));
  const auto priors = log.pose_priors();
  ASSERT_EQ(priors.size(), 4U);
  const auto robot_at = [](double share) { return Pose<2>{Point<2>(2.0 * share, 0.0), Rotation<2>(share * kQuarter)}; };
  const Pose<2> step = robot_at(1.0);
  EXPECT_EQ(priors[0].target, PoseIndex(0));
  EXPECT_LT((priors[0].lever - transform(robot_at(0.25), lever)).norm(), 1e-12);
  EXPECT_EQ(priors[1].target, PoseIndex(1));
  EXPECT_LT((transform(step, priors[1].lever) - transform(robot_at(0.75), lever)).norm(), 1e-12);
  EXPECT_EQ(priors[2].target, PoseIndex(2)) << "and where the step is stored backwards";
  EXPECT_LT((priors[2].lever - transform(robot_at(0.25), lever)).norm(), 1e-12);
  EXPECT_EQ(priors[3].target, PoseIndex(3));
  EXPECT_LT((transform(step, priors[3].lever) - transform(robot_at(0.75), lever)).norm(), 1e-12);
}

TEST(AttachFixes, TheFirstPoseMayHaveAFixOfItsOwn) {
  Log<2> log = log_of();
  ASSERT_TRUE(attach_fixes(fixes_of({fix_at(0.0)}), {}, log));
  EXPECT_EQ(log.pose_priors()[0].target, PoseIndex(0));
}

TEST(AttachFixes, OnlyOdometryBetweenNeighboursInTimeLeadsToAFix) {
  // Times by which pose 2 comes next after pose 0, though odometry leads from pose 0 to pose 1.
  Log<2> log = log_of();
  std::swap(log.stamps_ns[PoseIndex(1)], log.stamps_ns[PoseIndex(2)]);
  EXPECT_EQ(attach_fixes(fixes_of({fix_at(0.5), fix_at(1.0)}), {}, log).value().left_out, 1);
}

TEST(AttachFixes, TheDeviationsOfAFixAreThoseWhereItWasMade) {
  // A place far east of the origin, where north is another direction: meridians converge.
  Log<2> log = log_of();
  GpsFix far = fix_at(3.0);
  far.place.longitude += 2.0;
  ASSERT_TRUE(attach_fixes(fixes_of({fix_at(1.0), fix_at(2.0), far}), {}, log));
  const double converged = 2.0 * std::numbers::pi / 180.0 * std::sin(50.0 * std::numbers::pi / 180.0);
  const Matrix<2> R = Rotation<2>(converged).matrix();
  const Matrix<2> expected = R * Eigen::Vector2d(4.0, 0.25).asDiagonal() * R.transpose();
  const Matrix<2> covariance = log.pose_priors()[2].information.topLeftCorner<2, 2>().inverse();
  EXPECT_LT((covariance - expected).norm(), 0.02 * std::abs(expected(0, 1)) + 0.004) << covariance;
}

TEST(AttachFixes, AFixThatNoPoseIsNearIsCounted) {
  Log<2> log = log_of();
  const auto attached = attach_fixes(fixes_of({fix_at(-0.1), fix_at(4.1), fix_at(3.5), fix_at(1.5), fix_at(1.1), fix_at(1.7)}),
                                     {.most_apart = 0.4}, log)
                            .value();
  EXPECT_EQ(attached.left_out, 4) << "before the first pose, behind the last, where no odometry leads, and too far from both";
  EXPECT_EQ(log.pose_priors().size(), 2U);
}

TEST(AttachFixes, AnyTimeApartMayBeAllowed) {
  Log<2> log = log_of();
  EXPECT_EQ(attach_fixes(fixes_of({fix_at(1.5)}), {.most_apart = 1e12}, log).value().left_out, 0);
}

TEST(AttachFixes, TheTimeApartIsTakenToTheNanosecond) {
  Log<2> log = log_of();
  GpsFix fix = fix_at(1.0);
  fix.when = std::int64_t{1'000'000'015};
  EXPECT_EQ(attach_fixes(fixes_of({fix}), {.most_apart = 15e-9}, log).value().left_out, 0) << "1e9 * 15e-9 is less than 15";
}

TEST(AttachFixes, TheFixesReleaseWhatIsFixed) {
  Log<2> log = log_of();
  ASSERT_TRUE(attach_fixes(fixes_of({fix_at(1.0)}), {}, log));
  EXPECT_TRUE(log.graph.fixed.empty());
  EXPECT_EQ(log.skipped.at("fixed poses, for the fixes hold the map"), 1);
}

TEST(AttachFixes, AFixThatIsFarOffDoesNotMoveTheOrigin) {
  Log<2> log = log_of();
  GpsFix null_island = fix_at(3.0);
  null_island.place = {};
  const auto attached = attach_fixes(fixes_of({null_island, fix_at(1.0), fix_at(2.0)}), {}, log).value();
  EXPECT_EQ(attached.frame.origin().latitude, 50.0);
}

TEST(AttachFixes, AFixMayNameItsPose) {
  Log<2> log = log_of(0, false);
  GpsFix fix = fix_at(0.0);
  fix.when = std::uint64_t{3};
  GpsFix unknown = fix;
  unknown.when = std::uint64_t{99};
  EXPECT_EQ(attach_fixes(fixes_of({fix, unknown}), {}, log).value().left_out, 1);
  EXPECT_EQ(log.pose_priors()[0].target, PoseIndex(3));
}

TEST(AttachFixes, SessionsThatDroveAtOnceAreToldApartByName) {
  LogBuilder<2> builder("two.g2o");
  builder.append(log_of());
  builder.append(log_of(), 1);
  const Log<2> two = std::move(builder).finish().value();
  Log<2> log = two;
  const auto unclear = attach_fixes(fixes_of({fix_at(1.0, 4)}), {}, log);
  ASSERT_FALSE(unclear);
  EXPECT_THAT(unclear.error().message, HasSubstr("fixes.csv:4: pose 1 and pose 1 of session 1 could both"));
  GpsFix of_second = fix_at(1.0);
  of_second.session = 1;
  log = two;
  ASSERT_TRUE(attach_fixes(fixes_of({of_second}), {}, log));
  EXPECT_EQ(log.poses[log.pose_priors()[0].target], (PoseId{1, 1}));
  of_second.when = std::uint64_t{1};
  log = two;
  ASSERT_TRUE(attach_fixes(fixes_of({of_second}), {}, log));
  EXPECT_EQ(log.poses[log.pose_priors()[0].target], (PoseId{1, 1})) << "and by the name of the pose";
}

TEST(AttachFixes, RefusesNumbersThatNoReaderWouldTake) {
  const auto message = [](const auto& change) {
    GpsFixes fixes = fixes_of({fix_at(1.0)});
    fixes.fixes[0].line = 7;
    change(fixes.fixes);
    Log<2> log = log_of();
    return testing::error_of(attach_fixes(fixes, {}, log));
  };
  const std::string wrong = "fixes.csv:7: a fix has a latitude up to 90, a longitude up to 360 degrees";
  EXPECT_EQ(message([](auto&) {}), "");
  EXPECT_EQ(message([](auto& fixes) { fixes.clear(); }), "fixes.csv: there are no fixes");
  EXPECT_THAT(message([](auto& fixes) { fixes[0].place.latitude = 90.1; }), HasSubstr(wrong));
  EXPECT_THAT(message([](auto& fixes) { fixes[0].place.longitude = std::nan(""); }), HasSubstr(wrong));
  EXPECT_THAT(message([](auto& fixes) { fixes[0].deviation[1] = 0.0; }), HasSubstr(wrong));
  EXPECT_THAT(message([](auto& fixes) { fixes[0].deviation[0] = -1.0; }), HasSubstr(wrong));
  EXPECT_THAT(message([](auto& fixes) { fixes[0].deviation[0] = 1e-200; }), HasSubstr(wrong)) << "its square is 0";
  EXPECT_THAT(message([](auto& fixes) { fixes[0].deviation[2] = 1e200; }), HasSubstr(wrong)) << "its square is not finite";
  EXPECT_THAT(message([](auto& fixes) { fixes[0].place.height = std::nan(""); }), HasSubstr(wrong));
}

TEST(AttachFixes, OptionsThatMakeNoSenseAreRefused) {
  Log<2> log = log_of();
  GpsOptions options;
  options.most_apart = std::nan("");
  EXPECT_THROW(attach_fixes(fixes_of({fix_at(1.0)}), options, log).value(), std::invalid_argument);
  for (const double far : {std::nan(""), 1e300, -10001.0}) {
    options = {};
    options.lever[0] = far;
    EXPECT_THROW(attach_fixes(fixes_of({fix_at(1.0)}), options, log).value(), std::invalid_argument) << far;
  }
}

TEST(AttachFixes, SaysWhatIsMissing) {
  const auto message = [](const GpsFixes& fixes, auto log) { return attach_fixes(fixes, {}, log).error().message; };
  EXPECT_THAT(message(fixes_of({fix_at(1.0)}), log_of(0, false)), HasSubstr("--stamps gives them some, or a column pose"));
  EXPECT_THAT(message(fixes_of({fix_at(77.0)}), log_of()), HasSubstr("no fix is at a pose of log.g2o or within 1 s"));
  Log<2> with_prior = log_of();
  with_prior.graph.pose_factors.push_back({kWorld, 0, {}, PoseMatrix<2>::Identity()});
  EXPECT_THAT(message(fixes_of({fix_at(1.0)}), with_prior), HasSubstr("log.g2o has priors, which are in another frame"));
  Log<2> with_feature_prior = log_of();
  with_feature_prior.graph.feature_factors.push_back({kWorld, 0, Point<2>::Zero(), PointMatrix<2>::Identity()});
  EXPECT_THAT(message(fixes_of({fix_at(1.0)}), with_feature_prior),
              HasSubstr("log.g2o has priors, which are in another frame"));
  LogBuilder<3> in_space("space.g2o");
  in_space.add_pose_edge({0, 0}, {0, 1}, {}, PoseMatrix<3>::Identity());
  EXPECT_THAT(message({"fixes.csv", false, {fix_at(1.0)}}, std::move(in_space).finish().value()),
              HasSubstr("columns height and sd_up"));
}

}  // namespace
}  // namespace mapjoin
