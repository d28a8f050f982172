// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/localmap/build.hpp>
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
  this->expect_fault("do not cover the log");
  this->segments = right;
  this->segments.pop_back();
  this->expect_fault("do not cover the log");
  this->segments = right;
  this->segments.push_back(right.back());
  this->expect_fault("do not cover the log");
}

TYPED_TEST(CheckTest, WantsSegmentsOfOneSession) {
  const PoseIndex end = this->log.sessions.front().end;
  ++std::ranges::find(this->segments, PoseIndex(end - 1), &Segment::end)->end;
  this->expect_fault("do not cover the log");
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
