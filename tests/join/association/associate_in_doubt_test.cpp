// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mapjoin/join/association/associate_in_doubt.hpp>
#include <set>
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
  const auto right = joined(associate(world.log, {}).value().sightings);
  ASSERT_NE(joined(associate(log, {}).value().sightings), right);
  EXPECT_EQ(joined(associate_in_doubt(log, {}, {}).value().sightings), right);
}

/// A drive with a closure for each of some places seen again.
Log<2> closed_drive(const ManhattanOptions& options) {
  const Simulation<2> world = simulate_manhattan<2>(options);
  Log<2> log = world.log;
  const PoseIndex end(log.poses.size());
  for (PoseIndex from(0); from < end; from = from + 5) {
    for (PoseIndex to = from + 50; to < end; ++to) {
      const Pose<2> between_them = between(world.truth.poses[from], world.truth.poses[to]);
      if (between_them.translation.norm() > 2.0) continue;
      log.graph.pose_factors.push_back({from, to, between_them, 1e3 * Matrix<3>::Identity()});
      break;
    }
  }
  put_in_order(log);
  return log;
}

/// With so poor odometry the map is bent by the features alone.
TEST(AssociateInDoubt, BelievesClosuresOnceTheyFit) {
  const Log<2> log =
      closed_drive({.poses = 300, .seed = 5, .side = 25.0, .feature_cell = 4.0, .range = 3.5, .turn_noise = 0.04});
  Log<2> without = log;
  without.graph.pose_factors.resize(log.odometry().size());
  const auto right = associate(log, {}).value().sightings;
  ASSERT_LT(pair_score(associate(without, {}).value().sightings).recall, 0.7 * pair_score(right).recall);
  EXPECT_EQ(joined(associate_in_doubt(log, {}, {}).value().sightings), joined(right));
}

TEST(AssociateInDoubt, IsNotMisledByOdometryThatClosuresContradict) {
  Log<2> log = closed_drive({.poses = 160, .seed = 1, .side = 10.0, .feature_cell = 2.5, .feature_jitter = 1.2, .range = 5.0});
  Pose<2>& step = log.graph.pose_factors[80].measured;
  step = compose(step, Pose<2>{Point<2>(3.0, 2.0), Rotation<2>(0.5)});
  ASSERT_LT(pair_score(associate_in_doubt(log, {}, {}).value().sightings).recall, 0.8);
  const auto found = associate_in_doubt(log, {}, {.odometry = true}).value();
  EXPECT_GE(pair_score(found.sightings).precision, 0.999);
  EXPECT_GE(pair_score(found.sightings).recall, 0.97);
  EXPECT_EQ(found.data.odometry().size(), log.odometry().size());  // what is wrong is told, not dropped
}

/// Gives some observations of the second of two sessions the name of another feature of it; which ones.
template <int Dim>
std::set<std::size_t> misname(std::vector<FeatureFactor<Dim>>& observations) {
  const std::size_t first = observations.size() / 2 + 100;
  std::set<std::size_t> misnamed;
  for (std::size_t k = first + 20; k < observations.size(); k += 50) {
    observations[k].target = observations[first].target;
    misnamed.insert(k);
  }
  return misnamed;
}

TYPED_TEST(AssociateInDoubtTest, TiesSessionsInSpiteOfWrongNamesInThem) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = wood<kDim>(1);
  Log<kDim> log = in_two_sessions(world.log);
  AssociationOptions own;
  own.names_hold = true;
  const auto right = associate(log, own).value();
  ASSERT_TRUE(right.untied.empty());
  const auto misnamed = misname<kDim>(log.graph.feature_factors);
  ASSERT_FALSE(associate(log, own).value().untied.empty());

  const auto found = associate_in_doubt(log, own, {}).value();
  EXPECT_TRUE(found.untied.empty());
  ASSERT_EQ(found.data.observations().size(), log.observations().size());
  std::map<std::pair<std::uint32_t, FeatureId>, FeatureId> by_name;
  for (std::size_t k = 0; k < found.sightings.size(); ++k) {
    const AssociatedSighting& s = found.sightings[k];
    EXPECT_EQ(by_name.emplace(std::pair(s.base.session, s.name), s.joined).first->second, s.joined);  // also the misnamed ones
    EXPECT_TRUE(misnamed.contains(k) || s.joined == right.sightings[k].joined) << k;
  }
}

TEST(AssociateInDoubt, TiesLocalMapsInSpiteOfWrongNamesInThem) {
  SubmapSet<2> set = small_submap_set(in_two_sessions(wood<2>(1).log), 20);
  AssociationOptions own;
  own.names_hold = true;
  const auto right = associate(set, own).value();
  ASSERT_TRUE(right.untied.empty());
  auto& maps = set.graph.submaps;
  for (const std::size_t k : {maps.size() - 1, maps.size() - 4}) {
    std::swap(maps[k].features.front(), maps[k].features.back());
  }
  ASSERT_FALSE(associate(set, own).value().untied.empty());
  const auto found = associate_in_doubt(set, own, {}).value();
  EXPECT_TRUE(found.untied.empty());
  EXPECT_EQ(found.sightings.size(), right.sightings.size());
}

}  // namespace
}  // namespace mapjoin::testing
