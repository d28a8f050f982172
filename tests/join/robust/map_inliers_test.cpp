// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <tests/support/data.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <typename D>
class MapInliersTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static SubmapSet<kDim> maps() {
    const auto world = testing::small_world<kDim>({.poses = 120, .features = 30, .closures = 0, .range = 6.0});
    return testing::small_submap_set(world.log, 5.0);
  }
};
TYPED_TEST_SUITE(MapInliersTest, testing::Dimensions);

bool has(const auto& map, FeatureIndex feature) {
  return std::ranges::find(map.features, feature) != map.features.end();
}

TYPED_TEST(MapInliersTest, LosesNothingOfMapsThatFit) {
  const auto inliers = find_inliers(this->maps(), RobustOptions{}).value();
  EXPECT_TRUE(inliers.rejected.empty());
}

TYPED_TEST(MapInliersTest, LeavesTheFeatureOutThatIsUnderAnotherName) {
  auto set = this->maps();
  auto& map = set.graph.submaps[3];
  FeatureIndex other = 0;
  while (has(map, other)) ++other;
  const FeatureIndex own = std::exchange(map.features[1], other);
  const auto inliers = find_inliers(set, RobustOptions{}).value();
  ASSERT_EQ(inliers.rejected.size(), 1U);
  const Misfit& misfit = inliers.rejected.front().misfit;
  EXPECT_EQ(misfit.kind, PartKind::kMapFeature);
  EXPECT_EQ(misfit.from, map.base);
  EXPECT_EQ(std::get<FeatureIndex>(misfit.to), other);
  const auto& left = inliers.input.graph.submaps[3];
  EXPECT_FALSE(has(left, other) || has(left, own));
  EXPECT_EQ(left.features.size() + 1, map.features.size());
}

TYPED_TEST(MapInliersTest, OfMapsThatAreTooCertainLeavesLittleOutButWhatIsWrong) {
  auto set = this->maps();
  for (auto& map : set.graph.submaps) map.information *= 16.0;
  auto& map = set.graph.submaps[3];
  FeatureIndex other = 0;
  while (has(map, other)) ++other;
  map.features[1] = other;
  const auto inliers = find_inliers(set, RobustOptions{}).value();
  const auto is_wrong_one = [&](const Rejected& one) {
    return one.misfit.from == map.base && std::get<FeatureIndex>(one.misfit.to) == other;
  };
  EXPECT_EQ(std::ranges::count_if(inliers.rejected, is_wrong_one), 1);
  EXPECT_LE(inliers.rejected.size(), 2U);
  EXPECT_EQ(inliers.input.graph.submaps[5].information, set.graph.submaps[5].information) << "weights are as given";
}

TYPED_TEST(MapInliersTest, LeavesWhatTheMapSaysOfOtherFeaturesAsItWas) {
  constexpr int kDim = TypeParam::value;
  auto set = this->maps();
  auto& map = set.graph.submaps[3];
  FeatureIndex other = 0;
  while (has(map, other)) ++other;
  map.features[1] = other;
  const Eigen::MatrixXd before = map.information.inverse();  // covariance
  const auto inliers = find_inliers(set, RobustOptions{}).value();
  const Eigen::MatrixXd after = inliers.input.graph.submaps[3].information.inverse();
  const Eigen::Index first = map.row(map.poses.size() + 1);
  const Eigen::Index rest = before.rows() - first - kDim;
  ASSERT_EQ(after.rows(), before.rows() - kDim);
  const double tolerance = 1e-6 * before.norm();
  EXPECT_LT((after.topLeftCorner(first, first) - before.topLeftCorner(first, first)).norm(), tolerance);
  EXPECT_LT((after.bottomRightCorner(rest, rest) - before.bottomRightCorner(rest, rest)).norm(), tolerance);
  EXPECT_LT((after.topRightCorner(first, rest) - before.topRightCorner(first, rest)).norm(), tolerance);
}

TYPED_TEST(MapInliersTest, OfTwoObservationsFromOnePoseRejectsTheWrongOne) {
  constexpr int kDim = TypeParam::value;
  auto set = this->maps();
  const auto& map = set.graph.submaps[3];
  FeatureFactor<kDim> seen{map.base, map.features[1], map.feature_estimates[1], 100.0 * PointMatrix<kDim>::Identity()};
  set.graph.feature_factors.push_back(seen);
  seen.measured[0] += 5.0;
  set.graph.feature_factors.push_back(seen);
  const auto inliers = find_inliers(set, RobustOptions{}).value();
  ASSERT_EQ(inliers.rejected.size(), 1U);
  EXPECT_EQ(inliers.rejected.front().misfit.kind, PartKind::kObservation);
  ASSERT_EQ(inliers.input.graph.feature_factors.size(), set.graph.feature_factors.size() - 1);
  EXPECT_EQ(inliers.input.graph.feature_factors.back().measured, map.feature_estimates[1]);
}

TYPED_TEST(MapInliersTest, OfTwoMapsFromOnePoseRejectTheFeatureOfTheWrongOne) {
  auto set = this->maps();
  auto& maps = set.graph.submaps;
  maps.push_back(maps[3]);
  maps.back().feature_estimates[1][0] += 5.0;
  const FeatureIndex feature = maps[3].features[1];
  const auto inliers = find_inliers(set, RobustOptions{}).value();
  ASSERT_EQ(inliers.rejected.size(), 1U);
  EXPECT_TRUE(has(inliers.input.graph.submaps[3], feature));
  EXPECT_FALSE(has(inliers.input.graph.submaps.back(), feature));
}

TYPED_TEST(MapInliersTest, JudgeFeaturesAloneAlsoWhereMapsKeepPosesOnTheirWay) {
  constexpr int kDim = TypeParam::value;
  const auto world = testing::small_world<kDim>({.poses = 120, .features = 30, .closures = 6, .range = 6.0});
  auto set = testing::small_submap_set(world.log, 5.0);
  ASSERT_TRUE(std::ranges::any_of(set.graph.submaps, [](const auto& map) { return map.poses.size() > 1; }));
  EXPECT_TRUE(find_inliers(set, RobustOptions{}).value().rejected.empty());
  set.graph.pose_factors.clear();  // the closures
  auto& map = set.graph.submaps[3];
  map.feature_estimates[1][0] += 5.0;
  const auto rejected = find_inliers(set, RobustOptions{}).value().rejected;
  ASSERT_EQ(rejected.size(), 1U);
  EXPECT_EQ(std::get<FeatureIndex>(rejected[0].misfit.to), map.features[1]);
}

/// The numbers of features whose id at least two other maps give rightly; for a wrong id, both the id given and the true one.
struct Counts {
  int right = 0;
  int right_rejected = 0;
  int wrong = 0;
  int wrong_rejected = 0;
};

Counts count(const SubmapSet<2>& clean, const PlantedSet<2>& planted, const SubmapSet<2>& kept) {
  Table<FeatureIndex, int> sightings(clean.features.size());
  const auto for_each = [&](auto&& f) {
    for (std::size_t m = 0; m < planted.is_wrong.size(); ++m) {
      for (std::size_t k = 0; k < planted.is_wrong[m].size(); ++k) f(m, k, planted.is_wrong[m][k]);
    }
  };
  for_each([&](std::size_t m, std::size_t k, bool is_wrong) {
    if (!is_wrong) ++sightings[clean.graph.submaps[m].features[k]];
  });
  Counts counts;
  for_each([&](std::size_t m, std::size_t k, bool is_wrong) {
    const FeatureIndex own = clean.graph.submaps[m].features[k];
    const FeatureIndex given = planted.set.graph.submaps[m].features[k];
    if ((is_wrong ? std::min(sightings[own], sightings[given]) : sightings[own] - 1) < 2) return;
    const bool is_rejected = !has(kept.graph.submaps[m], given);
    ++(is_wrong ? counts.wrong : counts.right);
    (is_wrong ? counts.wrong_rejected : counts.right_rejected) += is_rejected ? 1 : 0;
  });
  return counts;
}

TEST(MapInliersData, NamesWrongIdentitiesAmongTheLocalMapsOfVictoriaPark) {
  const auto set = std::get<SubmapSet<2>>(open_maps(testing::data_file("vicpark-200-local-maps")).value());
  const auto planted = plant_wrong_identities(set, 0.1, 1);
  const auto inliers = find_inliers(planted.set, RobustOptions{}).value();
  const Counts counts = count(set, planted, inliers.input);
  ASSERT_GT(counts.wrong, 300);
  EXPECT_GE(counts.wrong_rejected, 0.95 * counts.wrong);
  EXPECT_LE(counts.right_rejected, 0.01 * counts.right);
}

}  // namespace
}  // namespace mapjoin
