// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mapjoin/io/merged_logs.hpp>
#include <mapjoin/join/association/associate_in_doubt.hpp>
#include <tests/support/cut_log.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/pair_score.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/wood.hpp>
#include <utility>

namespace mapjoin::testing {
namespace {

template <typename D>
class AssociateInDoubtTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// The world with closures between two stretches of `count` poses, as if the second one had been driven `off` metres away.
  static Log<kDim> closed(const Simulation<kDim>& world, std::size_t first, std::size_t second, std::size_t count, double off) {
    Log<kDim> log = world.log;
    const Pose<kDim> moved{off * Vector<kDim>::UnitX(), {}};
    for (std::size_t k = 0; k < count; ++k) {
      const PoseIndex from(first + k);
      const PoseIndex to(second + k);
      const Pose<kDim> measured = between(world.truth.poses[from], compose(moved, world.truth.poses[to]));
      log.graph.pose_factors.push_back({from, to, measured, 1e3 * PoseMatrix<kDim>::Identity()});
    }
    put_in_order(log);
    return log;
  }
};
TYPED_TEST_SUITE(AssociateInDoubtTest, Dimensions);

std::vector<FeatureId> joined(const std::vector<AssociatedSighting>& sightings) {
  std::vector<FeatureId> names;
  std::ranges::transform(sightings, std::back_inserter(names), &AssociatedSighting::joined);
  return names;
}

TYPED_TEST(AssociateInDoubtTest, FindsFeaturesInSpiteOfAWrongClosure) {
  const auto world = wood<TestFixture::kDim>(1);
  const auto log = TestFixture::closed(world, 10, 90, 1, 8.0);
  const auto right = joined(associate(world.log, {}).value().sightings);
  ASSERT_NE(joined(associate(log, {}).value().sightings), right);
  const auto found = associate_in_doubt(log, {}, {}).value();
  EXPECT_EQ(joined(found.sightings), right);
  EXPECT_EQ(found.data.closures().size(), 1);  // what is wrong is told, not dropped
}

TYPED_TEST(AssociateInDoubtTest, FindsFeaturesInSpiteOfWrongClosuresThatAgree) {
  const auto world = wood<TestFixture::kDim>(2);
  const auto log = TestFixture::closed(world, 10, 90, 6, 8.0);
  EXPECT_EQ(joined(associate_in_doubt(log, {}, {}).value().sightings), joined(associate(world.log, {}).value().sightings));
}

/// A drive with poor odometry, by whose features alone the map is bent, with a closure for each of some places seen again.
Log<2> drive_that_needs_closures() {
  ManhattanOptions options;
  options.seed = 7;
  options.poses = 300;
  options.side = 25.0;
  options.feature_cell = 4.0;
  options.range = 3.5;
  options.turn_noise = 0.04;
  const Simulation<2> world = simulate_manhattan<2>(options);
  Log<2> log = world.log;
  for (PoseIndex from(0); from < PoseIndex(200); from = from + 5) {
    for (PoseIndex to = from + 50; to < PoseIndex(300); ++to) {
      const Pose<2> between_them = between(world.truth.poses[from], world.truth.poses[to]);
      if (between_them.translation.norm() > 2.0) continue;
      log.graph.pose_factors.push_back({from, to, between_them, 1e3 * Matrix<3>::Identity()});
      break;
    }
  }
  put_in_order(log);
  return log;
}

TEST(AssociateInDoubt, BelievesClosuresOnceTheyFit) {
  const Log<2> log = drive_that_needs_closures();
  Log<2> without = log;
  without.graph.pose_factors.resize(log.odometry().size());
  const auto right = associate(log, {}).value().sightings;
  ASSERT_LT(pair_score(associate(without, {}).value().sightings).recall, 0.7 * pair_score(right).recall);
  EXPECT_EQ(joined(associate_in_doubt(log, {}, {}).value().sightings), joined(right));
}

/// Gives observations of the second session, from one on and every 50th, the name of the feature of the first of it.
template <int Dim>
void misname(std::vector<FeatureFactor<Dim>>& observations, std::size_t first) {
  const FeatureIndex name = observations[first].target;
  for (std::size_t k = first + 20; k < observations.size(); k += 50) observations[k].target = name;
}

TYPED_TEST(AssociateInDoubtTest, TiesSessionsInSpiteOfWrongNamesInThem) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = wood<kDim>(1);
  Log<kDim> log = merged<kDim>({cut_session(world.log, 0, 2), cut_session(world.log, 1, 2)}, {.own_features = true}).value();
  AssociationOptions own;
  own.names_hold = true;
  const auto right = associate(log, own).value();
  ASSERT_TRUE(right.untied.empty());
  misname<kDim>(log.graph.feature_factors, log.observations().size() / 2 + 100);

  const auto found = associate_in_doubt(log, own, {}).value();
  EXPECT_TRUE(found.untied.empty());
  EXPECT_EQ(found.data.observations().size(), log.observations().size());
  std::map<std::pair<std::uint32_t, FeatureId>, FeatureId> by_name;  // a wrong observation goes with its name
  for (const AssociatedSighting& s : found.sightings) {
    EXPECT_EQ(by_name.emplace(std::pair(s.base.session, s.name), s.joined).first->second, s.joined);
  }
  EXPECT_EQ(found.data.features.size(), right.data.features.size());
}

TYPED_TEST(AssociateInDoubtTest, TakesASetByItsNames) {
  constexpr int kDim = TestFixture::kDim;
  const auto set = small_submap_set(wood<kDim>(1).log, 20);
  AssociationOptions own;
  own.names_hold = true;
  EXPECT_EQ(joined(associate_in_doubt(set, own, {}).value().sightings), joined(associate(set, own).value().sightings));
}

}  // namespace
}  // namespace mapjoin::testing
