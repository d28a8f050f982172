// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/check/checks.hpp>
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
  log = with_headings(log, [](double angle) { return std::min(6.0, kDegrees * angle); });  // None beyond a full turn.
  EXPECT_THAT(warnings_of(log), Not(IsEmpty()));
  EXPECT_THAT(warnings_of(log), Each("degrees"));
}

TEST(Units, AreKnownByTurnsBeyondAFullOne) {
  Log<2> log = in_degrees(world({.features = 0}));
  EXPECT_THAT(warnings_of(log), Not(IsEmpty()));
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
