// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/check/checks.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> checks_of(const Findings& findings, FindingLevel level) {
  std::vector<std::string> checks;
  for (const Finding& finding : findings) {
    if (finding.level == level) checks.push_back(finding.check);
  }
  return checks;
}

const Finding& finding_of(const Findings& findings, const std::string& check) {
  const auto found = std::find_if(findings.begin(), findings.end(), [&](const auto& f) { return f.check == check; });
  if (found == findings.end()) throw std::runtime_error("there is no " + check);
  return *found;
}

template <typename Dimension>
class Structure : public ::testing::Test {};
TYPED_TEST_SUITE(Structure, Dimensions);

TYPED_TEST(Structure, OfALogThatHangsTogetherIsFine) {
  constexpr int Dim = TypeParam::value;
  const auto world = small_world<Dim>();
  EXPECT_TRUE(checks_of(check_structure(world.log), FindingLevel::kWarning).empty());
  EXPECT_TRUE(checks_of(check_structure(world.log), FindingLevel::kError).empty());
}

TYPED_TEST(Structure, NamesPartsThatNothingTiesTogether) {
  constexpr int Dim = TypeParam::value;
  LogBuilder<Dim> builder("some.g2o");
  builder.add_pose_edge({0, 0}, {0, 1}, {}, PoseMatrix<Dim>::Identity());
  builder.add_pose_edge({0, 5}, {0, 6}, {}, PoseMatrix<Dim>::Identity());
  builder.add_feature({9}, Point<Dim>::Zero());
  const Findings findings = check_structure(std::move(builder).finish().value());
  EXPECT_THAT(checks_of(findings, FindingLevel::kError), ElementsAre("parts", "unobserved"));
  EXPECT_THAT(finding_of(findings, "parts").where.names, ElementsAre("pose 0", "pose 5"));
  EXPECT_THAT(finding_of(findings, "unobserved").where.names, ElementsAre("feature 9"));
  EXPECT_THAT(finding_of(findings, "breaks").where.names, ElementsAre("pose 1 to pose 5"));
}

TYPED_TEST(Structure, NamesAPoseOfThePartThatTheWorldHolds) {
  constexpr int Dim = TypeParam::value;
  LogBuilder<Dim> builder("some.g2o");
  builder.add_pose_edge({0, 0}, {0, 1}, {}, PoseMatrix<Dim>::Identity());
  builder.add_pose_edge({0, 5}, {0, 6}, {}, PoseMatrix<Dim>::Identity());
  builder.fix({0, 5});
  const Log<Dim> fixed = std::move(builder).finish().value();
  EXPECT_THAT(finding_of(check_structure(fixed), "parts").where.names, ElementsAre("pose 0", "pose 5"));

  LogBuilder<Dim> with_prior("some.g2o");
  with_prior.add_pose_edge({0, 0}, {0, 1}, {}, PoseMatrix<Dim>::Identity());
  with_prior.add_feature_prior({7}, Point<Dim>::Zero(), PointMatrix<Dim>::Identity());
  const Log<Dim> apart = std::move(with_prior).finish().value();
  EXPECT_THAT(finding_of(check_structure(apart), "parts").where.names, ElementsAre("pose 0", "feature 7"));
}

/// Two sessions of four poses each, which both see the same `shared` features, and each five of its own.
template <int Dim>
Log<Dim> two_sessions(std::size_t shared) {
  LogBuilder<Dim> builder("some.g2o");
  for (std::uint32_t session = 0; session < 2; ++session) {
    for (std::uint64_t k = 0; k + 1 < 4; ++k) {
      builder.add_pose_edge({session, k}, {session, k + 1}, {}, PoseMatrix<Dim>::Identity());
    }
    const auto see = [&](std::uint64_t feature) {
      for (const std::uint64_t pose : {0u, 3u}) {
        builder.add_observation({session, pose}, {feature}, Point<Dim>::Zero(), PointMatrix<Dim>::Identity());
      }
    };
    for (std::size_t f = 0; f < shared; ++f) see(f);
    for (std::size_t f = 0; f < 5; ++f) see(100 * (session + 1) + f);
  }
  return std::move(builder).finish().value();
}

TYPED_TEST(Structure, CountsTheFeaturesThatHoldSessionsTogether) {
  constexpr int Dim = TypeParam::value;
  EXPECT_THAT(checks_of(check_structure(two_sessions<Dim>(0)), FindingLevel::kError), ElementsAre("parts"));
  const Findings loose = check_structure(two_sessions<Dim>(1));
  EXPECT_THAT(checks_of(loose, FindingLevel::kError), ElementsAre("loose_body"));
  EXPECT_THAT(checks_of(loose, FindingLevel::kWarning), ElementsAre("weak_feature"));
  EXPECT_EQ(finding_of(loose, "loose_body").where.count, 2u);
  EXPECT_THAT(checks_of(check_structure(two_sessions<Dim>(Dim)), FindingLevel::kWarning), ElementsAre("weak_body"));
  const Findings held = check_structure(two_sessions<Dim>(Dim + 1));
  EXPECT_TRUE(checks_of(held, FindingLevel::kError).empty());
  EXPECT_TRUE(checks_of(held, FindingLevel::kWarning).empty());
}

TYPED_TEST(Structure, OfLocalMapsOnlyNotesFeaturesOfOneMap) {
  constexpr int Dim = TypeParam::value;
  SubmapSet<Dim> set;
  set.poses = {{0, 0}, {0, 1}, {0, 2}};
  for (std::uint64_t f = 0; f < 30; ++f) set.features.push_back({f});
  for (PoseIndex k = 0; k < 2; ++k) {
    LocalMap<Dim> map;
    map.base = k;
    map.poses = {k + 1};
    for (int f = k == 0 ? 0 : 20; f < (k == 0 ? 22 : 30); ++f) map.features.emplace_back(f);
    set.graph.submaps.push_back(map);
  }
  const Findings findings = check_structure(set);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].check, "seen_once");
  EXPECT_EQ(findings[0].level, FindingLevel::kNote);
  EXPECT_EQ(findings[0].where.count, 28u);
}

TYPED_TEST(Structure, WarnsOfFeaturesSeenOnceOnlyWhereTheyAreMost) {
  constexpr int Dim = TypeParam::value;
  const auto log_with = [](std::uint64_t once) {
    LogBuilder<Dim> builder("some.g2o");
    builder.add_pose_edge({0, 0}, {0, 1}, {}, PoseMatrix<Dim>::Identity());
    for (std::uint64_t f = 0; f < 30; ++f) {
      for (std::uint64_t pose = 0; pose < (f < once ? 1 : 2); ++pose) {
        builder.add_observation({0, pose}, {f}, Point<Dim>::Zero(), PointMatrix<Dim>::Identity());
      }
    }
    return std::move(builder).finish().value();
  };
  EXPECT_EQ(finding_of(check_structure(log_with(15)), "seen_once").level, FindingLevel::kNote);
  const Findings most = check_structure(log_with(16));
  EXPECT_EQ(finding_of(most, "seen_once").level, FindingLevel::kWarning);
  EXPECT_EQ(finding_of(most, "seen_once").where.count, 16u);
}

TYPED_TEST(Structure, WarnsOfPosesThatAreNoLaterThanTheOneBefore) {
  constexpr int Dim = TypeParam::value;
  const PoseIds ids = {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 0}, {1, 1}};
  const auto log_at = [&](const std::vector<std::int64_t>& times) {
    LogBuilder<Dim> builder("some.g2o");
    for (std::size_t k = 0; k < times.size(); ++k) builder.add_stamp(ids.at(k), times[k]);
    for (const std::size_t k : {0U, 1U, 2U, 4U})
      builder.add_pose_edge(ids.at(k), ids.at(k + 1), {}, PoseMatrix<Dim>::Identity());
    return std::move(builder).finish().value();
  };
  const auto is_of_stamps = [](const Finding& finding) { return finding.check == "stamps"; };
  EXPECT_TRUE(std::ranges::none_of(check_structure(log_at({})), is_of_stamps));
  EXPECT_TRUE(std::ranges::none_of(check_structure(log_at({1, 2, 3, 4, 1, 2})), is_of_stamps)) << "each session has its own";
  const Finding finding = finding_of(check_structure(log_at({1, 2, 2, 1, 7, 6})), "stamps");
  EXPECT_EQ(finding.level, FindingLevel::kWarning);
  EXPECT_EQ(finding.where.names, (std::vector<std::string>{"pose 2", "pose 3", "pose 1 of session 1"}));
}

TEST(TwoLogsInOneFile, AreNoticed) {
  const auto log_of = [](std::uint64_t first_steps, std::uint64_t second_steps) {
    LogBuilder<2> builder("log");
    for (const std::uint64_t steps : {first_steps, second_steps}) {
      for (std::uint64_t k = 0; k < steps; ++k) builder.add_pose_edge({0, k}, {0, k + 1}, {}, PoseMatrix<2>::Identity());
    }
    return std::move(builder).finish().value();
  };
  EXPECT_EQ(count_steps(log_of(30, 20)).driven_twice(), 20u);
  EXPECT_EQ(finding_of(check_structure(log_of(30, 20)), "driven_twice").where.count, 20u);
  EXPECT_EQ(count_steps(log_of(30, 15)).driven_twice(), 0u) << "as many steps have one edge";
  EXPECT_EQ(count_steps(log_of(9, 9)).driven_twice(), 0u);
}

TYPED_TEST(Structure, WarnsOfFeaturesSeenOnceOnlyFromTwentyFeaturesOn) {
  constexpr int Dim = TypeParam::value;
  for (const std::uint64_t features : {19u, 20u}) {
    LogBuilder<Dim> builder("some.g2o");
    builder.add_pose_edge({0, 0}, {0, 1}, {}, PoseMatrix<Dim>::Identity());
    for (std::uint64_t f = 0; f < features; ++f)
      builder.add_observation({0, 0}, {f}, Point<Dim>::Ones(), PointMatrix<Dim>::Identity());
    const Finding finding = finding_of(check_structure(std::move(builder).finish().value()), "seen_once");
    EXPECT_EQ(finding.level, features == 20 ? FindingLevel::kWarning : FindingLevel::kNote);
  }
}

}  // namespace
}  // namespace mapjoin::testing
