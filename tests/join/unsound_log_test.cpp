// SPDX-License-Identifier: BSD-3-Clause
// A log that was changed by hand and names what it does not have, at every door of the library.
#include <gtest/gtest.h>

#include <mapjoin/check/checks.hpp>
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/incremental/submap_update_maker.hpp>
#include <mapjoin/join/robust/fix_inliers.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/study/basin.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <mapjoin/join/study/convexity.hpp>
#include <stdexcept>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::error_of;

template <typename D>
class UnsoundLog : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  UnsoundLog() {
    log.graph.pose_factors.back().target = 1000;
    wrong = error_of(check_invariants(log));
  }

  Log<kDim> log = testing::small_world<kDim>({.poses = 30, .features = 10, .closures = 4}).log;
  Split parts = split(log, {SplitRule::kPoses, 5.0});
  std::vector<LocalMap<kDim>> maps = build_local_maps(log, parts, {}).value().maps;
  std::string wrong;
};
TYPED_TEST_SUITE(UnsoundLog, testing::Dimensions);

TYPED_TEST(UnsoundLog, IsRefusedByWhatJoinsIt) {
  ASSERT_NE(this->wrong, "");
  EXPECT_EQ(error_of(run(this->log, RunOptions{})), this->wrong);
  EXPECT_EQ(error_of(solve(this->log, RunOptions{})), this->wrong);
  EXPECT_EQ(error_of(run_from_maps(this->log, this->parts, this->maps, RunOptions{})), this->wrong);
  EXPECT_EQ(error_of(build_local_maps(this->log, this->parts, {})), this->wrong);
  EXPECT_EQ(error_of(associate(this->log, AssociationOptions{})), this->wrong);
  EXPECT_EQ(error_of(find_inliers(this->log, RobustOptions{})), this->wrong);
  EXPECT_EQ(error_of(find_wrong_fixes(this->log, RobustOptions{})), this->wrong);
  GpsFixes fixes;
  fixes.fixes.emplace_back().deviation.setOnes();
  fixes.has_heights = true;
  EXPECT_EQ(error_of(attach_fixes(fixes, GpsOptions{}, this->log)), this->wrong);
}

TYPED_TEST(UnsoundLog, IsRefusedByWhatStudiesIt) {
  constexpr int kDim = TestFixture::kDim;
  EXPECT_EQ(error_of(basin(this->log, BasinOptions{})), this->wrong);
  EXPECT_EQ(error_of(convexity(this->log, ConvexityOptions{})), this->wrong);
  EXPECT_EQ(error_of(compare(this->log, ComparisonOptions<kDim>{})), this->wrong);
}

TYPED_TEST(UnsoundLog, IsFoundByItsCheckAlone) {
  const Findings findings = check_structure(this->log);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].level, FindingLevel::kError);
  EXPECT_EQ(findings[0].check, "unsound");
  EXPECT_EQ(findings[0].text, this->wrong);
  EXPECT_TRUE(check_repeats(this->log).empty());
  EXPECT_TRUE(check_units(this->log).empty());
}

TYPED_TEST(UnsoundLog, IsABrokenPromiseToWhatCutsIt) {
  EXPECT_THROW(split(this->log, {SplitRule::kPoses, 5.0}), std::invalid_argument);
  EXPECT_THROW(split_along(this->log, this->parts.segments), std::out_of_range);
  EXPECT_THROW(submap_updates_of(this->log, this->parts, this->maps), std::invalid_argument);
  SubmapUpdateMaker<TestFixture::kDim> maker({SplitRule::kPoses, 5.0});
  EXPECT_THROW(maker.add(this->log), std::invalid_argument);
}

}  // namespace
}  // namespace mapjoin
