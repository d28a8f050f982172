// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <map>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <numbers>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/pair_score.hpp>
#include <tests/support/random.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

/// A drive through a wood: a feature every few metres, off the lattice at random.
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

/// The log in space, with features this much higher than the poses (m).
Log<3> in_space(const Log<2>& flat, double height) {
  const std::vector<Eigen::Index> in_plane = {0, 1, 5};
  LogBuilder<3> builder(flat.source);
  for (const auto& step : flat.odometry()) {
    const Vector<2>& p = step.measured.translation;
    const Vector<3> turn(0.0, 0.0, step.measured.rotation.angle());
    Matrix<6> W = step.information(0, 0) * Matrix<6>::Identity();
    W(3, 3) = W(4, 4) = step.information(2, 2);
    W(in_plane, in_plane) = step.information;
    builder.add_pose_edge(flat.poses[step.base], flat.poses[step.target], {Point<3>(p.x(), p.y(), 0.0), Rotation<3>::exp(turn)},
                          W);
  }
  for (const auto& seen : flat.observations()) {
    builder.add_observation(flat.poses[seen.base], flat.features[seen.target],
                            Point<3>(seen.measured.x(), seen.measured.y(), height),
                            seen.information(0, 0) * Matrix<3>::Identity());
  }
  return std::move(builder).finish().value();
}

/// A drive along a row of trees and back, the row 2 m from the path. Steps are measured with errors, trees with errors along
/// the row only.
Log<2> along_a_row() {
  constexpr std::uint64_t kThere = 150;
  constexpr double kStep = 0.2;
  testing::Random random(5);
  std::vector<double> trees;
  for (double at = -6.0; at < 36.0; at += 2.0) trees.push_back(at + random.uniform(-0.5, 0.5));
  LogBuilder<2> builder("row");
  const Matrix<3> W = Vector<3>(4e3, 4e3, 1e6).asDiagonal();
  for (std::uint64_t k = 0; k <= 2 * kThere; ++k) {
    const bool turns = k == kThere + 1;
    const Point<2> forward(turns ? -kStep : kStep, 0.0);
    const Rotation<2> turn(turns ? std::numbers::pi : 0.0);
    if (k > 0) builder.add_pose_edge({0, k - 1}, {0, k}, {forward + random.vector<2>(0.02), turn}, W);
    const bool is_back = k > kThere;
    const double x = kStep * static_cast<double>(is_back ? 2 * kThere - k : k);
    for (std::size_t t = 0; t < trees.size(); ++t) {
      if (std::abs(trees[t] - x) > 6.0) continue;
      const double along = trees[t] - x + random.uniform(-0.05, 0.05);
      const Point<2> seen = is_back ? Point<2>(-along, -2.0) : Point<2>(along, 2.0);
      builder.add_observation({0, k}, {t}, seen, 1e3 * Matrix<2>::Identity());
    }
  }
  return std::move(builder).finish().value();
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

TEST(AssociateTest, FindsInAPlaneOfSpaceWhatItFindsInThePlane) {
  const Log<2> log = wood<2>();
  const auto flat = testing::pair_score(associate(log, AssociationOptions{}).value().sightings);
  for (const double height : {0.0, 1.2}) {
    const auto found = associate(in_space(log, height), AssociationOptions{}).value();
    const auto score = testing::pair_score(found.sightings);
    EXPECT_GE(score.precision, flat.precision - 0.001) << height;
    EXPECT_GE(score.recall, flat.recall - 0.01) << height;
  }
}

TEST(AssociateTest, FindsFeaturesThatAllLieOnALine) {
  const Log<2> log = along_a_row();
  for (const auto& sightings : {associate(log, AssociationOptions{}).value().sightings,
                                associate(in_space(log, 1.2), AssociationOptions{}).value().sightings}) {
    const auto score = testing::pair_score(sightings);
    EXPECT_GE(score.precision, 0.99);
    EXPECT_GE(score.recall, 0.95);
  }
}

/// A sighting far from its feature is still of it where poses would hardly have overlooked another one.
TEST(AssociateTest, KnowsThatASurelySeenFeatureIsNotOverlooked) {
  const Log<2> log = simulate_manhattan<2>({.poses = 150,
                                            .seed = 4,
                                            .side = 10.0,
                                            .feature_cell = 4.0,
                                            .feature_jitter = 0.5,
                                            .range = 5.0,
                                            .observation_noise = 0.05})
                         .log;
  const auto found = associate(log, AssociationOptions{}).value();
  const auto score = testing::pair_score(found.sightings);
  EXPECT_GE(score.precision, 0.99);
  EXPECT_GE(score.recall, 0.85);
  EXPECT_LE(found.data.features.size(), 30u) << "of " << log.features.size();
}

/// The log with one observation of each pose, at random.
Log<2> one_by_one(Log<2> log) {
  testing::Random random(1);
  std::map<PoseIndex, std::vector<FeatureFactor<2>>> of_poses;
  for (const auto& o : log.observations()) of_poses[o.base].push_back(o);
  log.graph.feature_factors.clear();
  for (const auto& [pose, seen] : of_poses) {
    const auto place = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(seen.size())));
    log.graph.feature_factors.push_back(seen[std::min(place, seen.size() - 1)]);
  }
  return log;
}

/// A sensor that gives one feature at a time does not show how densely they stand.
TEST(AssociateTest, DoesNotTakeWhatIsSeenAtOnceForAllThereIs) {
  const Log<2> log = one_by_one(simulate_manhattan<2>({.poses = 400,
                                                       .seed = 3,
                                                       .side = 10.0,
                                                       .feature_cell = 1.5,
                                                       .feature_jitter = 0.75,
                                                       .range = 4.0,
                                                       .observation_noise = 0.2})
                                    .log);
  EXPECT_GE(testing::pair_score(associate(log, AssociationOptions{}).value().sightings).precision, 0.99);
}

/// Where features stand in rows, each pair of maps could lie one step further on: what is probable of each is not so of all.
TEST(AssociateTest, LaysNoPairOfManyMapsOneStepFurtherOn) {
  const Log<2> log = simulate_manhattan<2>({.poses = 1000, .seed = 5}).log;
  EXPECT_GE(testing::pair_score(associate(log, AssociationOptions{}).value().sightings).precision, 0.999);
}

/// How well features are told apart on a log like the bundled one, of another seed: a sensor sees few of them, and turns are
/// hardly known.
testing::PairScore score_where_turns_are_hardly_known(std::uint64_t seed) {
  const Log<2> log =
      simulate_manhattan<2>({.poses = 1000, .seed = seed, .side = 45.0, .feature_cell = 4.0, .range = 3.5, .turn_noise = 0.03})
          .log;
  return testing::pair_score(associate(log, AssociationOptions{}).value().sightings);
}

/// Pairings fit that a map should have seen, that fit only each other, or that are far off for want of knowledge.
TEST(AssociateTest, IsMisledByNoRowsWhereTurnsAreHardlyKnown) {
  const testing::PairScore score = score_where_turns_are_hardly_known(19);
  EXPECT_GE(score.precision, 0.999);
  EXPECT_GE(score.recall, 0.97);
}

/// Here the first search lays maps in a wrong place that fits badly, and sees half of the features twice.
TEST(AssociateTest, FindsByAnotherSearchWhatAWrongPlaceHides) {
  const testing::PairScore score = score_where_turns_are_hardly_known(561);
  EXPECT_GE(score.precision, 0.999);
  EXPECT_GE(score.recall, 0.98);
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

/// Positions would not help: nothing tells where the last pose is.
TEST(AssociateTest, SaysWhatElseCannotBeDetermined) {
  LogBuilder<2> builder("ranges.g2o");
  const Matrix<2> along = Vector<2>(1.0, 0.0).asDiagonal();
  for (std::uint64_t k = 0; k < 4; ++k) {
    const Matrix<3> W = (k < 3 ? 1.0 : 0.0) * Matrix<3>::Identity();
    if (k > 0) builder.add_pose_edge({0, k - 1}, {0, k}, {Point<2>(1.0, 0.0), {}}, W);
    builder.add_observation({0, k}, {k}, Point<2>(2.0, 0.0), along);
  }
  const auto log = std::move(builder).finish().value();
  EXPECT_THAT(testing::error_of(associate(log, AssociationOptions{})),
              ::testing::AllOf(::testing::StartsWith("ranges.g2o: "), ::testing::HasSubstr("cannot be determined"),
                               ::testing::Not(::testing::HasSubstr("ranges or bearings"))));
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
