// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/localmap/split.hpp>
#include <set>
#include <stdexcept>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::small_world;

template <typename D>
class SplitTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  /// A log of `poses` poses, about 1 m apart, that see nothing.
  static Log<kDim> corridor(int poses) {
    return small_world<kDim>({.poses = poses, .features = 0, .closures = 0, .noise = 0.0}).log;
  }
  static FeatureFactor<kDim> observation(PoseIndex pose, FeatureIndex feature) {
    return {pose, feature, Point<kDim>::Zero(), PointMatrix<kDim>::Identity()};
  }
  static PoseFactor<kDim> edge(PoseIndex base, PoseIndex target) { return {base, target, {}, PoseMatrix<kDim>::Identity()}; }
  static int steps(const Segment& segment) { return segment.end - segment.begin; }
};
TYPED_TEST_SUITE(SplitTest, testing::Dimensions);

const std::vector<SplitOptions> kRules = {{SplitRule::kAuto, 0.0},     {SplitRule::kPoses, 1.0},    {SplitRule::kPoses, 7.0},
                                          {SplitRule::kPoses, 1e6},    {SplitRule::kDistance, 4.5}, {SplitRule::kFeatures, 3.0},
                                          {SplitRule::kFeatures, 1e6}, {SplitRule::kDistance, 1e-3}};

TYPED_TEST(SplitTest, EveryObservationBelongsToOneSegmentWhateverTheRule) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>({.sessions = 3, .reversed_odometry = true});
  const Log<kDim>& log = world.log;
  for (const SplitOptions& rule : kRules) {
    std::multiset<const void*> used;
    for (const Segment& segment : split(log, rule).segments) {
      for (const auto& o : odometry_of(log, segment)) used.insert(&o);
      for (const auto& o : observations_of(log, segment)) used.insert(&o);
    }
    std::multiset<const void*> all;
    for (const auto& o : log.odometry()) all.insert(&o);
    for (const auto& o : log.observations()) all.insert(&o);
    EXPECT_EQ(used, all) << static_cast<int>(rule.rule) << " " << rule.amount;
  }
}

TYPED_TEST(SplitTest, SegmentsOfASessionFollowEachOtherAndShareTheirEnds) {
  constexpr int kDim = TestFixture::kDim;
  const Log<kDim> log = small_world<kDim>({.sessions = 3}).log;
  for (const SplitOptions& rule : kRules) {
    const Split parts = split(log, rule);
    std::size_t session = 0;
    PoseIndex next = log.sessions[0].begin;
    for (const Segment& segment : parts.segments) {
      EXPECT_EQ(segment.begin, next);
      EXPECT_GT(segment.end, segment.begin);
      EXPECT_TRUE(parts.kept[segment.begin]);
      EXPECT_TRUE(parts.kept[segment.end]);
      next = segment.end;
      if (next + 1 < log.sessions[session].end) continue;
      ASSERT_EQ(next + 1, log.sessions[session].end);
      if (++session < log.sessions.size()) next = log.sessions[session].begin;
    }
    EXPECT_EQ(session, log.sessions.size());
  }
}

TYPED_TEST(SplitTest, CountsSteps) {
  const auto parts = split(this->corridor(24), {SplitRule::kPoses, 10.0});
  ASSERT_EQ(parts.segments.size(), 3u);
  EXPECT_EQ(parts.segments[1], (Segment{10, 20, true}));
  EXPECT_EQ(parts.segments[2], (Segment{20, 23, true}));
  EXPECT_EQ(parts.poses_per_map, 10);
  EXPECT_EQ(std::count(parts.kept.begin(), parts.kept.end(), true), 4);
}

TYPED_TEST(SplitTest, MeasuresDistanceAlongOdometry) {
  auto log = this->corridor(13);
  for (auto& step : log.graph.pose_factors) step.measured.translation *= 2.0 / step.measured.translation.norm();
  const auto parts = split(log, {SplitRule::kDistance, 5.9});
  ASSERT_EQ(parts.segments.size(), 4u);
  for (const Segment& segment : parts.segments) EXPECT_EQ(this->steps(segment), 3);
  EXPECT_EQ(parts.poses_per_map, 0);
}

TYPED_TEST(SplitTest, CountsDifferentFeatures) {
  auto log = this->corridor(9);
  for (std::uint64_t k = 0; k < 8; ++k) log.features.push_back({k});
  // Features k/2 and 7, seen from pose k.
  for (PoseIndex pose = 0; pose < 9; ++pose) {
    log.graph.feature_factors.push_back(this->observation(pose, FeatureIndex(pose.value / 2)));
    log.graph.feature_factors.push_back(this->observation(pose, 7));
  }
  const auto parts = split(log, {SplitRule::kFeatures, 3.0});
  ASSERT_EQ(parts.segments.size(), 4u);
  EXPECT_EQ(parts.segments[0], (Segment{0, 3, true}));  // features 0, 7 and 1 from pose 0 to pose 2
  EXPECT_EQ(parts.segments[1], (Segment{3, 5, true}));  // features 1, 7 and 2 from pose 3 to pose 4
}

TYPED_TEST(SplitTest, OneStepStaysRaw) {
  for (const Segment& segment : split(this->corridor(5), {SplitRule::kPoses, 1.0}).segments) EXPECT_FALSE(segment.is_map);
}

TYPED_TEST(SplitTest, KeepsWhatClosuresAndTheWorldReference) {
  auto log = this->corridor(31);
  log.graph.pose_factors.push_back(this->edge(3, 25));
  log.graph.pose_factors.push_back(this->edge(kWorld, 7));
  log.graph.fixed = {{13, {}}};
  const auto parts = split(log, {SplitRule::kPoses, 10.0});
  std::vector<PoseIndex> kept;
  for (const PoseIndex p : indices(parts.kept)) {
    if (parts.kept[p]) kept.push_back(p);
  }
  EXPECT_EQ(kept, (std::vector<PoseIndex>{0, 3, 7, 10, 13, 20, 25, 30}));
}

TYPED_TEST(SplitTest, ASegmentThatWouldKeepMostOfItsPosesStaysRaw) {
  auto log = this->corridor(21);
  for (PoseIndex pose = 1; pose <= 5; ++pose) log.graph.pose_factors.push_back(this->edge(pose, 15));
  log.graph.pose_factors.push_back(this->edge(6, 15));
  const auto parts = split(log, {SplitRule::kPoses, 10.0});
  EXPECT_FALSE(parts.segments[0].is_map);  // keeps 6 of 9 inner poses
  EXPECT_TRUE(parts.segments[1].is_map);   // keeps 1 of 9 inner poses
  EXPECT_EQ(std::count(parts.kept.begin(), parts.kept.begin() + 11, true), 11);
}

TYPED_TEST(SplitTest, AMapEliminatesHalfOfItsInnerPosesAtLeast) {
  for (const int closures : {5, 6}) {
    auto log = this->corridor(23);
    for (PoseIndex pose = 1; pose.value <= closures; ++pose) log.graph.pose_factors.push_back(this->edge(pose, 22));
    const auto parts = split(log, {SplitRule::kPoses, 11.0});  // with 10 inner poses
    EXPECT_EQ(parts.segments[0].is_map, closures == 5);
  }
}

TYPED_TEST(SplitTest, AMapWhoseBorderWouldBeTooLargeStaysRaw) {
  constexpr int kDim = TestFixture::kDim;
  constexpr int kMost = (5000 - 2 * kPoseDof<kDim>) / kDim;  // features beside the two ends
  for (const int features : {kMost, kMost + 1}) {
    auto log = this->corridor(11);
    for (std::size_t f = 0; f < static_cast<std::size_t>(features); ++f) log.features.push_back({f});
    for (const PoseIndex pose : {PoseIndex(2), PoseIndex(5)}) {
      for (const FeatureIndex f : indices(log.features)) log.graph.feature_factors.push_back(this->observation(pose, f));
    }
    EXPECT_EQ(split(log, {SplitRule::kPoses, 10.0}).segments[0].is_map, features == kMost) << features;
  }
}

TYPED_TEST(SplitTest, ASessionMayBeASinglePose) {
  constexpr int kDim = TestFixture::kDim;
  const Log<kDim> log = this->corridor(1);
  const auto parts = split(log, {SplitRule::kPoses, 5.0});
  ASSERT_EQ(parts.segments.size(), 1u);
  EXPECT_EQ(parts.segments[0], (Segment{0, 0, false}));
}

TYPED_TEST(SplitTest, ASegmentKnowsItsInteriorItsKeptPosesAndItsFeatures) {
  constexpr int kDim = TestFixture::kDim;
  auto log = this->corridor(11);
  for (std::uint64_t k = 0; k < 4; ++k) log.features.push_back({k});
  log.graph.feature_factors = {this->observation(0, 3), this->observation(2, 1), this->observation(4, 3),
                               this->observation(5, 2), this->observation(10, 0)};
  log.graph.pose_factors.push_back(this->edge(8, 2));
  const Split parts = split(log, {SplitRule::kPoses, 5.0});
  const SegmentView<kDim> first = segment_view(log, parts, parts.segments[0]);
  EXPECT_EQ(first.interior, (std::vector<PoseIndex>{1, 3, 4}));
  EXPECT_EQ(first.kept, (std::vector<PoseIndex>{2, 5}));
  EXPECT_EQ(first.features, (Table<FeatureIndex, FeatureIndex>{1, 3}));  // pose 5 belongs to the next segment
  EXPECT_EQ(first.place(FeatureIndex(3)), FeatureIndex(1));
  const SegmentView<kDim> last = segment_view(log, parts, parts.segments[1]);
  EXPECT_EQ(last.features, (Table<FeatureIndex, FeatureIndex>{0, 2}));  // the last segment takes those of the last pose, too
  EXPECT_EQ(last.poses(), 6u);
}

TYPED_TEST(SplitTest, EveryLocalMapIsInOneShare) {
  const auto log = this->corridor(24);
  Split parts = split(log, {SplitRule::kPoses, 2.0});
  make_raw(parts.segments[3], parts);
  const std::size_t maps = map_segments(parts.segments).size();
  for (const std::size_t count : {1u, 3u, 5u, 40u}) {
    std::vector<int> owners(parts.segments.size(), 0);
    std::vector<std::size_t> shares;  // the maps of each share, in its order
    for (std::size_t k = 0; k < count; ++k) {
      const auto segments = segments_of({k, count}, parts);
      const std::size_t own = map_segments(segments).size();
      EXPECT_TRUE(own == maps / count || own == maps / count + 1) << own;
      for (std::size_t s = 0; s < segments.size(); ++s) {
        owners[s] += segments[s].is_map;
        if (segments[s].is_map) shares.push_back(s);
      }
    }
    EXPECT_TRUE(std::ranges::is_sorted(shares)) << "the first share has the first maps";
    for (std::size_t s = 0; s < owners.size(); ++s) EXPECT_EQ(owners[s], parts.segments[s].is_map ? 1 : 0);
  }
}

TYPED_TEST(SplitTest, RefusesWhatMakesNoSense) {
  const auto log = this->corridor(10);
  EXPECT_THROW(split(log, {SplitRule::kPoses, std::nan("")}), std::invalid_argument);
  EXPECT_THROW(split(log, {SplitRule::kAuto, -1.0}), std::invalid_argument);
  EXPECT_THROW(split(log, {SplitRule::kPoses, 2.0}, Table<PoseIndex, bool>(9, true)), std::invalid_argument);
}

TEST(SplitOptions, NameEveryViolation) {
  EXPECT_TRUE(SplitOptions{}.validate().empty());
  EXPECT_TRUE((SplitOptions{SplitRule::kPoses, 1.0}).validate().empty());
  EXPECT_EQ((SplitOptions{SplitRule::kPoses, 0.0}).validate().size(), 1u);
  EXPECT_EQ((SplitOptions{SplitRule::kDistance, std::nan("")}).validate().size(), 1u);
  EXPECT_EQ((SplitOptions{SplitRule::kFeatures, -1.0}).validate().size(), 1u);
}

}  // namespace
}  // namespace mapjoin
