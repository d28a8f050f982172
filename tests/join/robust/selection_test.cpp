// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/robust/selection.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/same_log.hpp>
#include <tests/support/small_world.hpp>
#include <tests/support/two_drives.hpp>

namespace mapjoin {
namespace {

using Chosen = std::vector<std::size_t>;

template <typename D>
class SelectionTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Two drives with three closures between them.
  static Log<kDim> drives() { return testing::two_drives<kDim>(30, {{3, 3}, {9, 9}, {20, 20}}); }
  static Chosen tied(const Log<kDim>& log, const std::vector<bool>& is_chosen) {
    return tied_together(log, {1.0, 5.0, 3.0}, is_chosen);
  }
};
TYPED_TEST_SUITE(SelectionTest, testing::Dimensions);

TYPED_TEST(SelectionTest, HasSomeClosuresAndObservationsAndAllElse) {
  constexpr int kDim = TypeParam::value;
  Log<kDim> log = testing::small_world<kDim>({.closures = 4}).log;
  log.graph.pose_factors.push_back({kWorld, 3, {}, PoseMatrix<kDim>::Identity()});
  log.graph.feature_factors.push_back({kWorld, 2, Point<kDim>::Zero(), PointMatrix<kDim>::Identity()});
  std::vector<bool> observations(log.observations().size(), false);
  observations[5] = observations[9] = true;
  const Log<kDim> some = selected(log, {1, 2}, observations);
  testing::expect_same_observations(some.odometry(), log.odometry(), {});
  testing::expect_same_observations(some.closures(), log.closures().subspan(1, 2), {});
  testing::expect_same_observations(some.pose_priors(), log.pose_priors(), {});
  ASSERT_EQ(some.observations().size(), 2U);
  testing::expect_same_observations(some.observations().first(1), log.observations().subspan(5, 1), {});
  testing::expect_same_observations(some.observations().last(1), log.observations().subspan(9, 1), {});
  testing::expect_same_observations(some.feature_priors(), log.feature_priors(), {});
  EXPECT_EQ(some.features.size(), log.features.size());
}

TYPED_TEST(SelectionTest, HasAllObservationsWhereNoFlagsAreGiven) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = testing::small_world<kDim>().log;
  testing::expect_same_observations(selected(log, {}, {}).observations(), log.observations(), {});
}

TYPED_TEST(SelectionTest, TakesTheLikeliestClosureThatTiesTwoDrivesTogether) {
  EXPECT_EQ(this->tied(this->drives(), {false, false, false}), Chosen{1});
}

TYPED_TEST(SelectionTest, TakesNoOtherWhereTheChosenOnesTieThemTogether) {
  EXPECT_EQ(this->tied(this->drives(), {true, false, false}), Chosen{0});
  EXPECT_EQ(this->tied(this->drives(), {true, false, true}), (Chosen{0, 2}));
}

TYPED_TEST(SelectionTest, TakesNoneWhereAFeatureOrTheWorldTiesThemTogether) {
  constexpr int kDim = TypeParam::value;
  Log<kDim> by_feature = this->drives();
  by_feature.features = {{7}};
  for (const PoseIndex pose : {PoseIndex(2), PoseIndex(32)}) {
    by_feature.graph.feature_factors.push_back({pose, 0, Point<kDim>::Zero(), PointMatrix<kDim>::Identity()});
  }
  EXPECT_EQ(this->tied(by_feature, {false, false, false}), Chosen{});
  Log<kDim> by_prior = this->drives();
  by_prior.graph.fixed.push_back({0, {}});
  EXPECT_EQ(this->tied(by_prior, {false, false, false}), Chosen{1}) << "only one of them is held";
  by_prior.graph.pose_factors.push_back({kWorld, 40, {}, PoseMatrix<kDim>::Identity()});
  EXPECT_EQ(this->tied(by_prior, {false, false, false}), Chosen{});
}

TYPED_TEST(SelectionTest, TakesAClosureAcrossAStepThatLeavesADirectionFree) {
  Log<TypeParam::value> log = this->drives();
  log.graph.pose_factors[5].information.row(1).setZero();
  log.graph.pose_factors[5].information.col(1).setZero();
  EXPECT_EQ(this->tied(log, {false, false, false}), (Chosen{0, 1}));
  EXPECT_EQ(this->tied(log, {true, false, false}), (Chosen{0, 1}));
  std::swap(log.graph.pose_factors[5].information, log.graph.pose_factors[25].information);  // no closure crosses this one
  EXPECT_EQ(this->tied(log, {false, false, false}), Chosen{1});
}

TYPED_TEST(SelectionTest, KeepsOfEachFeatureTheObservationThatTheLeastIsAgainst) {
  constexpr int kDim = TypeParam::value;
  Log<kDim> log = this->drives();
  log.features = {{7}, {8}, {9}};
  for (const int feature : {0, 0, 1, 1, 2}) {
    log.graph.feature_factors.push_back({2, FeatureIndex(feature), Point<kDim>::Zero(), PointMatrix<kDim>::Identity()});
  }
  std::vector<bool> observations = {false, false, true, false, false};
  keep_one_of_each_feature(log, {4.0, 3.0, 9.0, 1.0, 99.0}, observations);
  EXPECT_EQ(observations, (std::vector<bool>{false, true, true, false, true}));
}

}  // namespace
}  // namespace mapjoin
