// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/localmap/build.hpp>
#include <stdexcept>
#include <string>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

/// A log of two sessions with its local maps.
template <typename D>
class CheckTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  void SetUp() override {
    Split built = split(log, {SplitRule::kPoses, 7.0});
    maps = build_local_maps<kDim>(log, built, {}).value().maps;
    segments = built.segments;
    ASSERT_GT(maps.size(), 4U);
  }
  void expect_fault(const std::string& words) const {
    const auto checked = check_local_maps(log, split_along(log, segments), maps);
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(checked.error().message, HasSubstr(words));
  }

  Log<kDim> log = testing::small_world<kDim>({.poses = 30, .sessions = 2}).log;
  std::vector<LocalMap<kDim>> maps;
  std::vector<Segment> segments;
};
TYPED_TEST_SUITE(CheckTest, testing::Dimensions);

TYPED_TEST(CheckTest, TakesTheMapsOfTheLog) {
  EXPECT_TRUE(check_local_maps(this->log, split_along(this->log, this->segments), this->maps));
}

TYPED_TEST(CheckTest, WantsSegmentsThatCoverEverySession) {
  const auto right = this->segments;
  this->segments.erase(this->segments.begin() + 1);
  this->expect_fault("segment 2 does not run on within its session");
  this->segments = right;
  if (this->segments.back().is_map) this->maps.pop_back();
  this->segments.pop_back();
  this->expect_fault("do not cover the log");
  this->SetUp();
  this->segments.push_back(right.back());
  this->expect_fault("does not run on within its session");
  this->segments.clear();
  this->expect_fault("its poses are in no segment");
}

TYPED_TEST(CheckTest, WantsSegmentsOfOneSession) {
  const PoseIndex end = this->log.sessions.front().end;
  ++std::ranges::find(this->segments, PoseIndex(end - 1), &Segment::end)->end;
  this->expect_fault("does not run on within its session");
}

TYPED_TEST(CheckTest, WantsSegmentsOfPosesOfTheLog) {
  const PoseIndex behind = indices(this->log.poses).last;
  for (const Segment& wrong : {Segment{7, 0}, Segment{0, 0}, Segment{0, behind}, Segment{0, -1}, Segment{-1, 3}}) {
    Split parts = split_along(this->log, this->segments);
    parts.segments.front() = wrong;
    EXPECT_FALSE(check_split(this->log, parts)) << wrong.begin.value << " to " << wrong.end.value;
  }
  EXPECT_THROW(split_along(this->log, {{0, behind}}), std::invalid_argument);
  EXPECT_THROW(split_along(this->log, {{-1, 3}}), std::invalid_argument);
}

TYPED_TEST(CheckTest, WantsEveryPoseKeptThatOthersReferTo) {
  const Split right = split_along(this->log, this->segments);
  ASSERT_TRUE(check_split(this->log, right));
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}}) {
    Split cut = right;
    cut.kept.resize(size);
    const auto checked = check_split(this->log, cut);
    ASSERT_FALSE(checked);
    EXPECT_THAT(checked.error().message, HasSubstr("says of " + std::to_string(size) + " poses which of them stay"));
  }
  for (const PoseIndex p : indices(this->log.poses)) {
    Split without = right;
    without.kept[p] = false;
    EXPECT_EQ(check_split(this->log, without).has_value(), !right.kept[p]);
  }
}

TYPED_TEST(CheckTest, TakesTheSplitOfTheFirstPartOfALog) {
  Split part = split_along(this->log, this->segments);
  part.segments.pop_back();
  EXPECT_TRUE(check_split(this->log, part));
}

TYPED_TEST(CheckTest, WantsAMapForEverySegmentThatIsOne) {
  this->maps.pop_back();
  this->expect_fault("the local map from");
  this->SetUp();
  this->maps.push_back(this->maps.back());
  this->expect_fault("there are more local maps than segments for them");
}

TYPED_TEST(CheckTest, WantsTheBaseThePosesAndTheFeaturesOfTheSegment) {
  const auto right = this->maps;
  std::swap(this->maps[0], this->maps[1]);
  this->expect_fault("is not of this log");
  this->maps = right;
  this->maps[1].features.back() = indices(this->log.features).last;
  this->expect_fault("is not of this log");
  this->maps = right;
  this->maps[1].poses.pop_back();
  this->expect_fault("is not of this log");
}

TYPED_TEST(CheckTest, WantsNumbersThatAreSound) {
  this->maps[1].information(0, 0) = -1.0;
  this->expect_fault("has an information matrix that");
}

}  // namespace
}  // namespace mapjoin
