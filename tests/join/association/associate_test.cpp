// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/sighting_fit.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/pair_score.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

/// A feature every few metres, off the lattice by chance.
template <int Dim>
Log<Dim> wood(std::int64_t poses = Dim == 2 ? 300 : 80) {
  ManhattanOptions options;
  options.poses = poses;
  options.side = Dim == 2 ? 15.0 : 12.0;
  options.range = Dim == 2 ? 5.0 : 6.0;
  options.feature_cell = Dim == 2 ? 2.5 : 4.0;
  options.feature_jitter = 0.8;
  return simulate_manhattan<Dim>(options).log;
}

template <typename D>
class AssociateTest : public ::testing::Test {};
TYPED_TEST_SUITE(AssociateTest, testing::Dimensions);

TYPED_TEST(AssociateTest, FindsTheFeaturesOfALogWhoseNamesAreHidden) {
  const auto log = wood<TypeParam::value>();
  const auto found = associate(log, AssociationOptions{}).value();
  const auto score = testing::pair_score(found.sightings);
  EXPECT_GE(score.precision, 0.99);
  EXPECT_GE(score.recall, 0.95);
  EXPECT_EQ(found.sightings.size(), log.observations().size());
  const auto result = run(found.data, RunOptions{}).value();
  EXPECT_LT(result.chi2, chi_squared_quantile(0.999, static_cast<double>(result.dof)));
}

TYPED_TEST(AssociateTest, FindsTheFeaturesOfLocalMapsWhoseNamesAreHidden) {
  const auto set = testing::small_submap_set(wood<TypeParam::value>(), 20.0);
  const auto score = testing::pair_score(associate(set, AssociationOptions{}).value().sightings);
  EXPECT_GE(score.precision, 0.99);
  EXPECT_GE(score.recall, 0.95);
}

TEST(AssociateTest, DoesNotLookAtNames) {
  const Log<2> log = wood<2>(100);
  Log<2> renamed = log;
  std::ranges::reverse(renamed.features);
  for (auto& observation : renamed.graph.feature_factors) {
    observation.target = FeatureIndex(static_cast<std::int32_t>(log.features.size()) - 1 - observation.target.value);
  }
  const auto a = associate(log, AssociationOptions{}).value();
  const auto b = associate(renamed, AssociationOptions{}).value();
  for (std::size_t s = 0; s < a.sightings.size(); ++s) EXPECT_EQ(a.sightings[s].joined, b.sightings[s].joined);
}

TEST(AssociateTest, IsTheSameForAnyNumberOfThreads) {
  const Log<2> log = wood<2>(150);
  const auto several = associate(log, AssociationOptions{}).value();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto alone = associate(log, AssociationOptions{}).value();
  for (std::size_t s = 0; s < alone.sightings.size(); ++s) {
    EXPECT_EQ(alone.sightings[s].joined, several.sightings[s].joined);
    EXPECT_EQ(alone.sightings[s].distance, several.sightings[s].distance);
  }
}

TEST(AssociateTest, CallsFeaturesInTheOrderOfTheirFirstSighting) {
  const auto found = associate(wood<2>(60), AssociationOptions{}).value();
  std::uint64_t known = 0;
  for (const AssociatedSighting& sighting : found.sightings) {
    EXPECT_LE(sighting.joined.key, known + 1);
    EXPECT_EQ(sighting.joined.key > known, !sighting.distance);
    known = std::max(known, sighting.joined.key);
  }
  EXPECT_EQ(known, found.data.features.size());
}

TEST(AssociateTest, SaysThatRangesAloneAreNotEnough) {
  LogBuilder<2> builder("ranges.g2o");
  const Matrix<2> along = Vector<2>(1.0, 0.0).asDiagonal();
  for (std::uint64_t k = 0; k < 4; ++k) {
    if (k > 0) builder.add_pose_edge({0, k - 1}, {0, k}, {Point<2>(1.0, 0.0), {}}, Matrix<3>::Identity());
    builder.add_observation({0, k}, {k}, Point<2>(2.0, 0.0), along);
  }
  const auto log = std::move(builder).finish().value();
  EXPECT_THAT(testing::error_of(associate(log, AssociationOptions{})),
              ::testing::StartsWith("ranges.g2o: observations of ranges or bearings alone leave features free to move"));
}

TEST(AssociateTest, RefusesPriorsOfFeaturesWhichGoByTheirNames) {
  LogBuilder<2> builder("log");
  builder.add_pose_edge({0, 0}, {0, 1}, {}, PoseMatrix<2>::Identity());
  builder.add_observation({0, 0}, {5}, {1.0, 2.0}, PointMatrix<2>::Identity());
  builder.add_feature_prior({5}, {1.0, 2.0}, PointMatrix<2>::Identity());
  const auto found = associate(std::move(builder).finish().value(), AssociationOptions{});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, ErrorKind::kBadInput);
  auto set = testing::small_submap_set(wood<2>(), 20.0);
  set.graph.feature_factors.push_back({kWorld, 0, Point<2>::Zero(), PointMatrix<2>::Identity()});
  EXPECT_EQ(
      testing::error_of(associate(set, AssociationOptions{})),
      set.source +
          ": has a prior of a feature, which --associate cannot find by its name again; leave out that prior, or --associate");
}

TEST(SightingFitTest, NamesTheMapThatTookAFeatureForAnother) {
  const Log<2> log = wood<2>();
  const SubmapSet<2> set = testing::small_submap_set(log, 20.0);
  std::vector<std::size_t> labels;
  for (const auto& map : set.graph.submaps) {
    for (const FeatureIndex feature : map.features) labels.push_back(feature.position());
  }
  const auto sightings = sightings_of(set);
  // Two features of one map change their names.
  constexpr std::size_t kMap = 7;
  std::vector<std::size_t> of_map;
  for (std::size_t s = 0; s < sightings.size(); ++s) {
    if (sightings[s].map == kMap) of_map.push_back(s);
  }
  std::swap(labels[of_map[0]], labels[of_map[1]]);
  const Identities identities(sightings, labels);
  const auto tests = tests_of(estimate_of(renamed(set, identities), {}).value(), identities);
  auto found = misfits(tests, chi_squared_quantile(0.9999, 2));
  ASSERT_GE(found.size(), 2U);
  std::ranges::sort(found, std::greater<>(), &SightingTest::chi2);
  EXPECT_EQ(found[0].map, kMap);
  EXPECT_EQ(found[1].map, kMap);
}

TEST(AssociateTest, SaysWhetherItHasComeToRest) {
  AssociationOptions options;
  EXPECT_TRUE(associate(wood<2>(), options)->is_settled);
  options.most_joins = 1;
  const auto hasty = associate(wood<2>(), options).value();
  EXPECT_FALSE(hasty.is_settled);
  EXPECT_EQ(hasty.joins, 1U);
}

TEST(AssociationOptionsTest, WantAConfidenceBetweenZeroAndOne) {
  EXPECT_TRUE(AssociationOptions{}.validate().empty());
  AssociationOptions certain;
  certain.confidence = 1.0;
  EXPECT_FALSE(certain.validate().empty());
}

TEST(AssociationOptionsTest, WantAJoinAtLeast) {
  AssociationOptions never;
  never.most_joins = 0;
  EXPECT_FALSE(never.validate().empty());
}

}  // namespace
}  // namespace mapjoin
