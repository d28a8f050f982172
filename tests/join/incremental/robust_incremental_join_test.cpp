// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/incremental/robust_incremental_join.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <tests/support/updates_of.hpp>

namespace mapjoin {
namespace {

template <int Dim>
SubmapUpdate<Dim> closure(const PoseId& from, const PoseId& to, const Pose<Dim>& measured) {
  SubmapUpdate<Dim> update;
  update.poses = {from, to};
  update.graph.pose_factors = {{0, 1, measured, 400.0 * PoseMatrix<Dim>::Identity(), {}}};
  return update;
}

/// Two robots that only their meetings tie together, and their updates.
template <int Dim>
struct TwoRobots {
  TwoRobots() {
    auto updates = testing::updates_of(world.log, 6.0);
    const auto half = updates.begin() + std::ssize(updates) / 2;
    first.assign(updates.begin(), half);
    second.assign(half, updates.end());
  }
  std::size_t turns() const { return first.size(); }
  /// The closure by which the robots see each other at the ends of their k-th segments.
  SubmapUpdate<Dim> meeting(std::size_t k) const {
    const IndexOf index_of(world.log.poses);
    const auto pose = [&](const PoseId& id) { return world.truth.poses[*index_of(id)]; };
    const PoseId from = last_pose(first[k]);
    const PoseId to = last_pose(second[k]);
    testing::Random random(static_cast<unsigned>(k));
    const Pose<Dim> seen = retract(between(pose(from), pose(to)), PoseVector<Dim>(random.vector<kPoseDof<Dim>>(0.02)));
    return closure(from, to, seen);
  }

  testing::SmallWorld<Dim> world = testing::small_world<Dim>({.poses = 60, .features = 0, .closures = 20, .sessions = 2});
  std::vector<SubmapUpdate<Dim>> first;
  std::vector<SubmapUpdate<Dim>> second;
};

template <typename D>
class RobustIncrementalJoinTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static Log<kDim> world(int features) {
    return testing::small_world<kDim>({.poses = 100, .features = features, .closures = 30}).log;
  }
};
TYPED_TEST_SUITE(RobustIncrementalJoinTest, testing::Dimensions);

TYPED_TEST(RobustIncrementalJoinTest, OfALogThatIsRightItIsTheIncrementalJoin) {
  constexpr int kDim = TestFixture::kDim;
  for (const int features : {0, 60}) {
    const auto log = this->world(features);
    RobustIncrementalJoin<kDim> joined;
    IncrementalJoin<kDim> plain;
    for (const auto& update : testing::updates_of(log, 6.0)) {
      const RobustlyAdded added = joined.add(update).value();
      EXPECT_TRUE(added.rejected.empty());
      EXPECT_NEAR(added.added.chi2, plain.add(update).value().chi2, 1e-3 * added.added.chi2 + 1e-3);
      EXPECT_EQ(added.added.dof, plain.dof());
    }
    EXPECT_TRUE(joined.left_out().empty());
  }
}

TYPED_TEST(RobustIncrementalJoinTest, AClosureThatIsTakenOutLeavesNoTrace) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = this->world(60);
  IncrementalJoin<kDim> without;
  IncrementalJoin<kDim> with;
  for (const auto& update : testing::updates_of(log, 6.0)) {
    without.add(update).value();
    with.add(update).value();
  }
  auto wrong = closure<kDim>(log.poses.front(), log.poses.back(), {});
  wrong.graph.pose_factors[0].information *= 0.1;  // it bends the map, but does not break it
  const std::size_t number = with.update_count();
  with.add(wrong).value();
  EXPECT_GT(local(*with.pose(log.poses.back()), *without.pose(log.poses.back())).norm(), 1e-2);
  const std::array numbers{number};
  const AddedUpdate out = with.change(numbers, {});
  EXPECT_TRUE(out.converged);
  EXPECT_NEAR(with.chi2(), without.chi2(), 1e-4 * without.chi2());
  EXPECT_EQ(with.dof(), without.dof());
  const auto expected = without.covariance(log.poses.back());
  const PoseVector<kDim> step = local(*without.pose(log.poses.back()), *with.pose(log.poses.back()));
  EXPECT_LT(step.dot(expected->llt().solve(step)), 0.1 * 0.1);
  EXPECT_LT((*with.covariance(log.poses.back()) - *expected).norm(), 0.02 * expected->norm());
  const AddedUpdate in = with.change({}, numbers);
  EXPECT_GT(in.metres, 1e-2);
  EXPECT_EQ(with.dof(), without.dof() + kPoseDof<kDim>);
}

TYPED_TEST(RobustIncrementalJoinTest, EndsAsTheWholeLogDoes) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = plant_wrong_closures(this->world(0), ClosurePolicy::kRandom, 8, 3).log;
  RobustIncrementalJoin<kDim> joined;
  for (const auto& update : testing::updates_of(log, 6.0)) joined.add(update).value();
  joined.judge();
  const auto inliers = find_inliers(log, RobustOptions{}).value();
  std::vector<ClosureName> rejected;
  for (const Rejected& one : inliers.rejected) {
    rejected.push_back({log.poses[one.misfit.from], log.poses[std::get<PoseIndex>(one.misfit.to)]});
  }
  auto left_out = joined.left_out();
  std::ranges::sort(left_out);
  std::ranges::sort(rejected);
  EXPECT_GE(rejected.size(), 7u);
  EXPECT_EQ(left_out, rejected);
  IncrementalJoin<kDim> plain;
  for (const auto& update : testing::updates_of<kDim>(inliers.input, 6.0)) plain.add(update).value();
  EXPECT_NEAR(joined.estimate().chi2(), plain.chi2(), 1e-3 * plain.chi2());
  EXPECT_EQ(joined.estimate().dof(), plain.dof());
}

TYPED_TEST(RobustIncrementalJoinTest, RobotsMayTakeTurns) {
  constexpr int kDim = TestFixture::kDim;
  const TwoRobots<kDim> robots;
  RobustIncrementalJoin<kDim> joined;
  std::vector<ClosureName> wrong;
  for (std::size_t k = 0; k < robots.turns(); ++k) {
    joined.add(robots.first[k]).value();
    joined.add(robots.second[k]).value();
    EXPECT_TRUE(joined.add(robots.meeting(k)).value().added.is_joined);
    if (k % 3 != 2) continue;
    const auto false_meeting = closure<kDim>(first_pose(robots.first[k]), last_pose(robots.second[k / 2]), {});
    joined.add(false_meeting).value();
    wrong.push_back({false_meeting.poses[0], false_meeting.poses[1]});
  }
  joined.judge();
  EXPECT_EQ(joined.estimate().waiting(), 0u);
  EXPECT_EQ(joined.left_out(), wrong);
}

TYPED_TEST(RobustIncrementalJoinTest, AWrongTieIsBelievedUntilOthersContradictIt) {
  constexpr int kDim = TestFixture::kDim;
  const TwoRobots<kDim> robots;
  const auto wrong = closure<kDim>(first_pose(robots.first[2]), last_pose(robots.second[0]), {});
  RobustIncrementalJoin<kDim> joined;
  IncrementalJoin<kDim> without;
  for (std::size_t k = 0; k < robots.turns(); ++k) {
    for (const auto& update : {robots.first[k], robots.second[k]}) {
      joined.add(update).value();
      without.add(update).value();
    }
    if (k == 0) continue;
    if (k == 2) {
      EXPECT_TRUE(joined.add(wrong).value().added.is_joined);
      EXPECT_TRUE(joined.left_out().empty());
    }
    if (k < 3) continue;
    joined.add(robots.meeting(k)).value();
    without.add(robots.meeting(k)).value();
  }
  EXPECT_EQ(joined.left_out(), (std::vector<ClosureName>{{wrong.poses[0], wrong.poses[1]}}));
  EXPECT_NEAR(joined.estimate().chi2(), without.chi2(), 1e-3 * without.chi2());
  EXPECT_EQ(joined.estimate().dof(), without.dof());
}

TYPED_TEST(RobustIncrementalJoinTest, OfBadInputNothingIsAdded) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = testing::updates_of(this->world(0), 6.0);
  RobustIncrementalJoin<kDim> joined;
  joined.add(updates[0]).value();
  auto bad = updates[1];
  bad.graph.pose_factors.push_back(
      {bad.segments[0].begin, enter_name(bad.poses, PoseId{7, 7}), {}, PoseMatrix<kDim>::Identity(), {}});
  const auto added = joined.add(bad);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().message, "update 2: pose 7 of session 7 is in no segment yet");
  EXPECT_EQ(joined.estimate().update_count(), 1u);
  EXPECT_FALSE(joined.estimate().pose(last_pose(updates[1])));
}

/// Some name themselves, and may do so by that number, too.
TYPED_TEST(RobustIncrementalJoinTest, CallsUpdatesWithoutASourceByTheirNumberAmongAll) {
  constexpr int kDim = TestFixture::kDim;
  auto updates = testing::updates_of(testing::small_world<kDim>({.poses = 40, .features = 0, .closures = 0}).log, 6.0);
  ASSERT_GE(updates.size(), 4u);
  updates[0].source = "update 1";
  updates[2].source = "update 3";
  RobustIncrementalJoin<kDim> joined;
  joined.add(updates[0]).value();
  joined.add_all({updates[1], updates[2]}).value();
  EXPECT_FALSE(joined.add(updates[1])) << "which does not count";
  joined.add(updates[3]).value();
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(joined.estimate().update(k).source, "update " + std::to_string(k + 1));
}

TYPED_TEST(RobustIncrementalJoinTest, OfBadClosuresNothingIsAdded) {
  constexpr int kDim = TestFixture::kDim;
  const auto updates = testing::updates_of(this->world(0), 6.0);
  RobustIncrementalJoin<kDim> joined;
  auto to_itself = updates[0];
  const PoseIndex end = to_itself.segments[0].end;
  to_itself.graph.pose_factors.push_back({end, end, {}, PoseMatrix<kDim>::Identity(), {}});
  const auto added = joined.add(to_itself);
  ASSERT_FALSE(added);
  EXPECT_TRUE(added.error().message.ends_with("leads from a pose to itself")) << added.error().message;
  auto to_nowhere = updates;
  to_nowhere.back().graph.pose_factors.push_back(
      {0, enter_name(to_nowhere.back().poses, PoseId{7, 7}), {}, PoseMatrix<kDim>::Identity(), {}});
  EXPECT_FALSE(joined.add_all(to_nowhere));
  EXPECT_EQ(joined.estimate().update_count(), 0u);
  for (const auto& update : updates) EXPECT_TRUE(joined.add(update));
}

TYPED_TEST(RobustIncrementalJoinTest, DoubtLastsUntilThereIsAVerdict) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = testing::small_world<kDim>({.poses = 60, .features = 0, .closures = 0});
  RobustIncrementalJoin<kDim> joined;
  for (const auto& update : testing::updates_of(world.log, 6.0)) joined.add(update).value();
  const auto seen = [&](PoseIndex from, PoseIndex to, double error) {
    Pose<kDim> measured = between(world.truth.poses[from], world.truth.poses[to]);
    measured.translation.x() += error;
    return closure<kDim>(world.log.poses[from], world.log.poses[to], measured);
  };
  std::stop_source source;
  source.request_stop();
  const RobustlyAdded interrupted = joined.add(seen(12, 24, 50.0), source.get_token()).value();
  ASSERT_TRUE(interrupted.no_verdict);
  EXPECT_EQ(interrupted.no_verdict->kind, ErrorKind::kInterrupted);
  const RobustlyAdded judged = joined.add(seen(18, 30, 0.0)).value();
  EXPECT_TRUE(judged.is_judged);
  EXPECT_FALSE(judged.no_verdict);
  EXPECT_FALSE(joined.add(seen(30, 42, 0.0)).value().is_judged);
  EXPECT_EQ(joined.left_out(), (std::vector<ClosureName>{{world.log.poses[12], world.log.poses[24]}}));
}

TYPED_TEST(RobustIncrementalJoinTest, WithoutAVerdictClosuresStayWhereTheyAre) {
  constexpr int kDim = TestFixture::kDim;
  RobustIncrementalJoin<kDim> joined;
  for (const auto& update : testing::updates_of(this->world(0), 6.0)) joined.add(update).value();
  std::stop_source source;
  source.request_stop();
  const RobustlyAdded judged = joined.judge(source.get_token());
  ASSERT_TRUE(judged.no_verdict);
  EXPECT_EQ(judged.no_verdict->kind, ErrorKind::kInterrupted);
  EXPECT_TRUE(judged.rejected.empty() && judged.readmitted.empty());
}

}  // namespace
}  // namespace mapjoin
