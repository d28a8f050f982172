// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/robust/support/sighting_support.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <tests/support/two_drives.hpp>

namespace mapjoin {
namespace {

template <typename D>
class SightingSupportTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  static std::vector<double> odds(const Log<kDim>& log) { return sighting_odds(OdometryChain<kDim>(log), log); }

  /// Two drives that see feature 0, to the left of their first poses, without error from the given poses, and another feature
  /// once, far off.
  static Log<kDim> sightings(const std::vector<PoseId>& poses) {
    Log<kDim> log = testing::two_drives<kDim>(100, {{5, 5}});
    const IndexOf index_of(log.poses);
    const PointMatrix<kDim> W = 1e4 * PointMatrix<kDim>::Identity();
    log.features = {{0}, {1}};
    for (const PoseId& id : poses) {
      Point<kDim> at = Point<kDim>::Zero();
      at.template head<2>() = Point<2>(-static_cast<double>(id.key), 2.0);
      log.graph.feature_factors.push_back({index_of(id).value(), 0, at, W});
    }
    log.graph.feature_factors.push_back({index_of({1, 99}).value(), 1, Point<kDim>::Constant(-10.0), W});
    return log;
  }
};
TYPED_TEST_SUITE(SightingSupportTest, testing::Dimensions);

TYPED_TEST(SightingSupportTest, IsAgainstTheOneUnderAWrongName) {
  constexpr int kDim = TypeParam::value;
  auto world = testing::small_world<kDim>({.poses = 40, .features = 12, .closures = 0, .range = 5.0});
  auto& observations = world.log.graph.feature_factors;
  std::vector<int> sightings(world.log.features.size());
  for (const auto& o : observations) ++sightings[o.target.position()];
  const auto is_known = [&](FeatureIndex f) { return sightings[f.position()] >= 5; };
  const auto wrong = std::ranges::find_if(observations, [&](const auto& o) { return is_known(o.target); });
  for (const FeatureIndex f : indices(world.log.features)) {
    if (f == wrong->target || !is_known(f)) continue;
    if ((world.truth.features[f] - world.truth.features[wrong->target]).norm() < 1.5) continue;
    wrong->target = f;
    break;
  }
  const std::vector<double> odds = this->odds(world.log);
  ASSERT_EQ(odds.size(), observations.size());
  for (std::size_t k = 0; k < odds.size(); ++k) {
    if (&observations[k] == &*wrong) {
      EXPECT_LT(odds[k], -5.0);
    } else if (is_known(observations[k].target)) {
      EXPECT_GT(odds[k], 3.0) << "observation " << k;
    }
  }
}

TYPED_TEST(SightingSupportTest, IsNoneWhereThereIsNothingToCompareWith) {
  const auto none = [](std::size_t count) { return std::vector<double>(count, 0.0); };
  EXPECT_EQ(this->odds(this->sightings({{0, 0}})), none(2));
  EXPECT_EQ(this->odds(this->sightings({{0, 0}, {1, 0}})), none(3)) << "no odometry between them";
  EXPECT_EQ(this->odds(testing::two_drives<TypeParam::value>(9, {{5, 5}})), none(0)) << "without features";
}

TYPED_TEST(SightingSupportTest, DoesNotCompareAcrossMoreThanSixtySteps) {
  EXPECT_GT(this->odds(this->sightings({{0, 0}, {0, 60}}))[0], 0.0);
  EXPECT_EQ(this->odds(this->sightings({{0, 0}, {0, 61}}))[0], 0.0);
}

TYPED_TEST(SightingSupportTest, TakesThoseOfAStretchForMistakenTogether) {
  std::vector<PoseId> poses{{0, 50}};
  for (std::uint64_t k = 51; k < 60; ++k) poses.push_back({0, k});
  EXPECT_NEAR(this->odds(this->sightings(poses))[0], 15.0, 0.01);
  for (std::uint64_t k = 0; k < 4; ++k) poses[6 + k] = {0, 75 + k};
  EXPECT_NEAR(this->odds(this->sightings(poses))[0], 30.0, 0.01);
}

}  // namespace
}  // namespace mapjoin
