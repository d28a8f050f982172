// SPDX-License-Identifier: BSD-3-Clause
// Maps held by the fixes of a satellite receiver.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/store.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/join/incremental/submap_update.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/study/convexity.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/gps_world.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

template <typename D>
class Gps : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
};
TYPED_TEST_SUITE(Gps, Dimensions);

TYPED_TEST(Gps, LeadsToTheOptimumOfCeres) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = gps_world<kDim>();
  const auto start_of = [](const auto& result) { return Values<kDim>{result.map.poses, result.map.features}; };
  const auto joined = run(world.log, RunOptions{}).value();
  const auto ceres = ceres_optimum(world.log, start_of(joined));
  EXPECT_NEAR(joined.chi2, ceres.chi2, 1e-8 * ceres.chi2);
  EXPECT_TRUE(joined.map.gauge.empty()) << "no pose is anchored";
  EXPECT_NEAR(solve(world.log, RunOptions{}).value().chi2, ceres.chi2, 1e-8 * ceres.chi2);
  const auto from_truth = ceres_optimum(world.log, world.truth);
  EXPECT_NEAR(from_truth.chi2, ceres.chi2, 1e-8 * ceres.chi2) << "and it is that next to the truth";
}

TYPED_TEST(Gps, TheMapStandsInTheFrameOfTheFixes) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = gps_world<kDim>({.deviation = 0.1});
  const auto map = run(world.log, RunOptions{}).value().map;
  for (const PoseIndex p : indices(map.poses)) {
    EXPECT_LT((map.poses[p].translation - world.truth.poses[p].translation).norm(), 0.5) << p.value;
  }
}

TYPED_TEST(Gps, NoPoseHangsFromAFix) {
  const auto world = gps_world<TestFixture::kDim>();
  RunOptions options;
  options.marginals = true;
  const auto relations = run(world.log, options).value().marginals->relations;
  EXPECT_EQ(std::ranges::count(relations.poses, kWorld, [](const auto& relation) { return relation.parent; }), 1);
}

TYPED_TEST(Gps, TheMapIsAsCertainAsItIsRight) {
  constexpr int kDim = TestFixture::kDim;
  double sum = 0.0;
  double dimensions = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto world = gps_world<kDim>({.poses = 100, .seed = seed});
    RunOptions options;
    options.covariances = true;
    const auto result = run(world.log, options).value();
    Truth<kDim> truth;
    truth.poses.assign(world.truth.poses.begin(), world.truth.poses.end());
    truth.features.assign(world.truth.features.begin(), world.truth.features.end());
    const auto consistent = consistency(*result.covariances, truth).value();
    sum += consistent.joint.value;
    dimensions += static_cast<double>(consistent.joint.dimensions);
  }
  EXPECT_GT(sum, chi_squared_quantile(0.01, dimensions));
  EXPECT_LT(sum, chi_squared_quantile(0.99, dimensions));
}

TEST(GpsPriors, WhatHasNoPlaceForLeversSaysSo) {
  const Log<2> log = gps_world<2>({.poses = 20}).log;
  Split parts = split(log, {SplitRule::kPoses, 5.0});
  const auto maps = build_local_maps(log, parts, {}).value().maps;
  const TemporaryFolder folder;
  EXPECT_THAT(convexity(log, parts, maps, {}).error().message, HasSubstr("priors with levers"));
  const auto store = StoreWriter<2>::open(folder.path() / "log.maps", log, parts.segments, "");
  ASSERT_FALSE(store);
  EXPECT_THAT(store.error().message, HasSubstr("a store has no place for priors with levers"));
  const auto updates = submap_updates_of(log, parts, maps);
  EXPECT_THAT(check_update(updates.front()).error().message, HasSubstr("priors with levers cannot be joined map by map"));
}

TYPED_TEST(Gps, AG2oFileOfTheMapHasTheSameOptimum) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = gps_world<kDim>();
  const auto joined = run(world.log, RunOptions{}).value();
  const TemporaryFolder folder;
  const auto file = folder.path() / "map.g2o";
  EXPECT_FALSE(write_g2o(world.log, file)) << "of a lever no value is known to take it off at";
  ASSERT_TRUE(write_g2o(joined.map, &world.log, file));
  const auto again = solve(std::get<Log<kDim>>(open_log(file).value()), RunOptions{}).value();
  EXPECT_NEAR(again.chi2, joined.chi2, 1e-6 * joined.chi2);
  for (const PoseIndex p : indices(again.map.poses)) {
    EXPECT_LT(local(again.map.poses[p], joined.map.poses[p]).norm(), 1e-4);
  }
}

}  // namespace
}  // namespace mapjoin::testing
