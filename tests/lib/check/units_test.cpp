// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <numbers>
#include <tests/support/small_world.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::Each;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::vector<std::string> warnings_of(const Log<2>& log) {
  std::vector<std::string> texts;
  for (const Finding& finding : check_units(log)) {
    if (finding.level == FindingLevel::kWarning) texts.push_back(finding.check);
  }
  return texts;
}

Log<2> world(const WorldOptions& options = {}) {
  return small_world<2>(options).log;
}

template <typename Change>
Log<2> with_headings(Log<2> log, Change&& change) {
  for (auto& edge : log.graph.pose_factors) edge.measured.rotation = Rotation<2>(change(edge.measured.rotation.angle()));
  return log;
}

Log<2> in_degrees(Log<2> log) {
  return with_headings(std::move(log), [](double angle) { return kDegrees * angle; });
}

TEST(Units, OfLogsInRadiansAreFine) {
  EXPECT_THAT(check_units(world({.closures = 0})), IsEmpty());
  EXPECT_THAT(check_units(world({.closures = 0, .reversed_odometry = true, .seed = 2})), IsEmpty());
  EXPECT_THAT(check_units(small_world<3>().log), IsEmpty());
}

TEST(Units, AreKnownByShortLoopsOfFeatures) {
  Log<2> log = world({.closures = 0});
  log = with_headings(log, [](double angle) { return std::min(6.0, kDegrees * angle); });  // none beyond a full turn
  EXPECT_THAT(warnings_of(log), Not(IsEmpty()));
  EXPECT_THAT(warnings_of(log), Each("degrees"));
}

TEST(Units, AreKnownByTurnsBeyondAFullOne) {
  Log<2> log = in_degrees(world({.features = 0}));
  EXPECT_THAT(warnings_of(log), Not(IsEmpty()));
}

TEST(Units, AreDoubtedFromMoreThanOneTurnInAHundredBeyondAFullOne) {
  for (const int poses : {101, 100}) {  // with 100 and 99 edges
    Log<2> log = world({.poses = poses, .features = 0, .closures = 0});
    ASSERT_EQ(log.edges().size(), static_cast<std::size_t>(poses - 1));
    log.graph.pose_factors[7].measured.rotation = Rotation<2>(7.0);
    EXPECT_EQ(warnings_of(log).size(), poses == 100 ? 1U : 0U);
  }
}

/// Steps that turn by 5 degrees, given as 5 radians. Each feature is seen from a pose and from the one `steps` steps later.
Log<2> seen_again_after(std::uint64_t steps, std::uint64_t poses = 60) {
  const Point<2> seen_first(3.0, 1.0);
  Point<2> seen_last = seen_first;
  for (std::uint64_t step = 0; step < steps; ++step) {
    seen_last = transform(inverse(Pose<2>{{1.0, 0.0}, Rotation<2>(5.0 / kDegrees)}), seen_last);
  }
  LogBuilder<2> builder("again");
  for (std::uint64_t pose = 0; pose < poses; ++pose) {
    builder.add_pose_edge({0, pose}, {0, pose + 1}, {{1.0, 0.0}, Rotation<2>(5.0)}, PoseMatrix<2>::Identity());
    builder.add_observation({0, pose}, {pose}, seen_first, PointMatrix<2>::Identity());
    if (pose >= steps) builder.add_observation({0, pose}, {pose - steps}, seen_last, PointMatrix<2>::Identity());
  }
  return std::move(builder).finish().value();
}

TEST(Units, AreJudgedByLoopsOfUpToTenSteps) {
  EXPECT_THAT(warnings_of(seen_again_after(10)), ::testing::ElementsAre("degrees"));
  EXPECT_THAT(warnings_of(seen_again_after(11)), IsEmpty());
}

TEST(Units, AreJudgedByTenLoopsAtLeast) {
  EXPECT_THAT(warnings_of(seen_again_after(1, 11)), ::testing::ElementsAre("degrees"));
  EXPECT_THAT(warnings_of(seen_again_after(1, 10)), IsEmpty());
}

/// Steps that turn by `turn`, then steps that hardly turn. A feature is seen from both ends of each step: from its end at one
/// place, from its start at the share `share` of the way from the place for an angle in degrees to that for radians; at half of
/// the way if the step hardly turns.
Log<2> seen_from_both_ends(std::uint64_t turns, std::uint64_t straight, double share, double turn = 5.0) {
  const Point<2> seen_last(3.0, 1.0);
  LogBuilder<2> builder("ends");
  for (std::uint64_t pose = 0; pose < turns + straight; ++pose) {
    const double angle = pose < turns ? turn : 1e-6;
    const double off = pose < turns ? share : 0.5;
    const Pose<2> step{{1.0, 0.0}, Rotation<2>(angle)};
    const Pose<2> by_degrees{{1.0, 0.0}, Rotation<2>(angle / kDegrees)};
    const Point<2> seen_first = (1.0 - off) * transform(by_degrees, seen_last) + off * transform(step, seen_last);
    builder.add_pose_edge({0, pose}, {0, pose + 1}, step, PoseMatrix<2>::Identity());
    builder.add_observation({0, pose}, {pose}, seen_first, PointMatrix<2>::Identity());
    builder.add_observation({0, pose + 1}, {pose}, seen_last, PointMatrix<2>::Identity());
  }
  return std::move(builder).finish().value();
}

TEST(Units, AreJudgedByLoopsThatTurn) {
  EXPECT_THAT(warnings_of(seen_from_both_ends(15, 45, 0.0)), ::testing::ElementsAre("degrees"));
  EXPECT_THAT(warnings_of(seen_from_both_ends(0, 60, 0.0)), IsEmpty());
  EXPECT_THAT(warnings_of(seen_from_both_ends(60, 0, 0.0, 0.02)), IsEmpty());
}

TEST(Units, AreThoseThatMissAThirdAsMuchAtMost) {
  EXPECT_THAT(warnings_of(seen_from_both_ends(60, 0, 0.2)), ::testing::ElementsAre("degrees"));
  EXPECT_THAT(warnings_of(seen_from_both_ends(60, 0, 0.3)), IsEmpty());
}

/// A log of which every fourth edge turns by `turn`, and the values `times` as far; in between edges hardly turn, and values
/// even less.
Log<2> with_values(double turn, double times) {
  LogBuilder<2> builder("values");
  double heading = 0.0;
  for (std::uint64_t pose = 0; pose < 40; ++pose) {
    const bool turns = pose % 4 == 0;
    builder.add_pose({0, pose}, Pose<2>{Point<2>::Zero(), Rotation<2>(heading)});
    heading += turns ? times * turn : 1e-5;
    builder.add_pose_edge({0, pose}, {0, pose + 1}, {{1.0, 0.0}, Rotation<2>(turns ? turn : 1e-4)}, PoseMatrix<2>::Identity());
  }
  builder.add_pose({0, 40}, Pose<2>{Point<2>::Zero(), Rotation<2>(heading)});
  return std::move(builder).finish().value();
}

TEST(Units, OfValuesAreComparedWhereTheyTurn) {
  for (const double turn : {0.1, 0.02}) {
    EXPECT_THAT(warnings_of(with_values(turn, kDegrees)), ::testing::ElementsAre("degrees")) << turn;
  }
}

TEST(Units, OfValuesAreThoseOfEdgesUnlessTheyTurnAsDegreesDo) {
  for (const double times : {1.0, 20.0, 75.0}) EXPECT_THAT(warnings_of(with_values(0.02, times)), IsEmpty()) << times;
}

TEST(Units, OfValuesAreComparedWithThoseOfEdges) {
  auto [log, truth] = small_world<2>({.features = 0, .closures = 0});
  log.initial.poses = truth.poses;
  EXPECT_THAT(warnings_of(log), IsEmpty());
  for (Pose<2>& pose : log.initial.poses) pose.rotation = Rotation<2>(kDegrees * pose.rotation.angle());
  EXPECT_THAT(warnings_of(log), ::testing::ElementsAre("degrees"));
}

TEST(Units, OfAnUncertaintyOfQuarterTurnsAreDoubted) {
  Log<2> log = world();
  for (auto& edge : log.graph.pose_factors) edge.information *= 1e-5;
  EXPECT_THAT(warnings_of(log), ::testing::ElementsAre("degrees"));
}

TEST(Units, OfTurnsBetweenAHalfAndAFullOneAreOnlyNoted) {
  const double full = 2.0 * std::numbers::pi;
  const Log<2> turned =
      with_headings(world({.closures = 0}), [full](double angle) { return angle > 0.0 ? angle - full : angle + full; });
  const Findings findings = check_units(turned);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings.front().check, "unwrapped");
  EXPECT_EQ(findings.front().level, FindingLevel::kNote);
}

}  // namespace
}  // namespace mapjoin::testing
