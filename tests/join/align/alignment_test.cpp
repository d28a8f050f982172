// SPDX-License-Identifier: BSD-3-Clause
// The placement of partial maps, against Eigen's Umeyama and against the chi2 of the observations between them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/align/shared_factors.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <numbers>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin::testing {
namespace {

template <typename D>
class AlignmentTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  using Points = std::vector<Point<kDim>>;

  Points scattered(std::size_t count, double away = 0.0) {
    Points points;
    for (std::size_t k = 0; k < count; ++k) points.push_back(random_.vector<kDim>(10.0) + Point<kDim>::Constant(away));
    return points;
  }
  Points moved(const Points& points, double noise) {
    const Pose<kDim> motion = random_.pose<kDim>(5.0, 2.0);
    Points result;
    for (const auto& point : points) result.push_back(transform(motion, point) + random_.vector<kDim>(noise));
    return result;
  }
  static void expect_umeyama(const Points& from, const Points& to, double tolerance) {
    Eigen::MatrixXd source(kDim, from.size());
    Eigen::MatrixXd destination(kDim, to.size());
    for (std::size_t k = 0; k < from.size(); ++k) {
      source.col(static_cast<Eigen::Index>(k)) = from[k];
      destination.col(static_cast<Eigen::Index>(k)) = to[k];
    }
    const Eigen::MatrixXd T = Eigen::umeyama(source, destination, false);
    const auto aligned = rigid_alignment<kDim>(from, to);
    ASSERT_TRUE(aligned);
    EXPECT_LT((aligned->rotation.matrix() - T.topLeftCorner<kDim, kDim>()).norm(), tolerance);
    for (const auto& point : from) {
      const Point<kDim> there = T.topLeftCorner<kDim, kDim>() * point + T.topRightCorner<kDim, 1>();
      EXPECT_LT((transform(*aligned, point) - there).norm(), tolerance * (1.0 + point.norm()));
    }
  }

  Random random_{5};
};
TYPED_TEST_SUITE(AlignmentTest, Dimensions);

TYPED_TEST(AlignmentTest, AlignsNoisyPointsAsUmeyamaDoes) {
  const auto points = this->scattered(12);
  this->expect_umeyama(points, this->moved(points, 0.3), 1e-9);
}

TYPED_TEST(AlignmentTest, AlignsFarFromTheOrigin) {
  const auto points = this->scattered(12, 1e6);
  this->expect_umeyama(points, this->moved(points, 0.3), 1e-8);
}

TYPED_TEST(AlignmentTest, AlignsMirroredPointsByARotation) {
  const auto points = this->scattered(12);
  auto mirrored = points;
  for (auto& point : mirrored) point[0] = -point[0];
  this->expect_umeyama(points, this->moved(mirrored, 0.1), 1e-9);
}

TYPED_TEST(AlignmentTest, IsByTheMajorityInLeastMedianOfSquares) {
  constexpr int kDim = TestFixture::kDim;
  const auto points = this->scattered(25);
  auto there = this->moved(points, 0.0);
  const auto right = rigid_alignment<kDim>(points, there);
  for (std::size_t k = 0; k < 11; ++k) there[k] += Point<kDim>::Constant(7.0 + static_cast<double>(k));
  const auto found = least_median_alignment<kDim>(points, there);
  ASSERT_TRUE(right && found);
  EXPECT_LT(local(*right, *found).norm(), 1e-9);
  EXPECT_GT(local(*right, *rigid_alignment<kDim>(points, there)).norm(), 1.0);
}

TYPED_TEST(AlignmentTest, LeastMedianOfSquaresTakesPointsThatDetermineAMotion) {
  constexpr int kDim = TestFixture::kDim;
  const typename TestFixture::Points one_place(9, Point<kDim>::Ones());
  EXPECT_FALSE(least_median_alignment<kDim>(one_place, one_place));
}

TYPED_TEST(AlignmentTest, AlignsPointsOfOnePlane) {
  constexpr int kDim = TestFixture::kDim;
  auto points = this->scattered(12);
  for (auto& point : points) point[kDim - 1] = 0.0;
  if (kDim == 2) points.front()[1] = 1.0;
  this->expect_umeyama(points, this->moved(points, 0.0), 1e-7);
}

TYPED_TEST(AlignmentTest, SaysNothingWhereNoRotationIsFixed) {
  constexpr int kDim = TestFixture::kDim;
  const auto points = this->scattered(12);
  EXPECT_FALSE(rigid_alignment<kDim>({points.front()}, {points.back()}));
  const typename TestFixture::Points coincident(12, points.front());
  EXPECT_FALSE(rigid_alignment<kDim>(coincident, points));
  EXPECT_FALSE(rigid_alignment<kDim>(points, coincident));
  auto on_a_line = points;
  for (std::size_t k = 0; k < on_a_line.size(); ++k) on_a_line[k] = static_cast<double>(k) * points.front();
  EXPECT_EQ(rigid_alignment<kDim>(on_a_line, points).has_value(), kDim == 2);
  auto undefined = points;
  undefined[3][0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(rigid_alignment<kDim>(undefined, points));
}

TYPED_TEST(AlignmentTest, TakesASpreadBeyondRoundingForARotation) {
  constexpr int kDim = TestFixture::kDim;
  for (const double spread : {1e-4, 1e-8}) {
    auto close = this->scattered(12);
    auto nearly_on_a_line = close;
    for (auto& point : close) point = Point<kDim>::Constant(10.0) + spread * point;
    for (auto& point : nearly_on_a_line) point.template tail<kDim - 1>() *= spread;
    EXPECT_EQ(rigid_alignment<kDim>(close, close).has_value(), spread == 1e-4);
    EXPECT_EQ(rigid_alignment<kDim>(nearly_on_a_line, nearly_on_a_line).has_value(), kDim == 2 || spread == 1e-4);
  }
}

TYPED_TEST(AlignmentTest, TakesASpreadForARotationHoweverFarFromTheOrigin) {
  constexpr int kDim = TestFixture::kDim;
  for (const double spread : {1e-1, 1e-6}) {
    auto far = this->scattered(12);
    for (auto& point : far) point = spread * point + Point<kDim>::Constant(5e6);
    EXPECT_EQ(rigid_alignment<kDim>(far, far).has_value(), spread == 1e-1);
  }
}

/// A line that turns by 30 degrees, and one that leads back, as a robot does that stays upright; the other points lie about it.
TEST(LeastTurningAlignment, AlignsALineInSpace) {
  for (const double angle : {0.5, std::numbers::pi}) {
    const Pose<3> motion{{100.0, -20.0, 3.0}, Rotation<3>::exp({0.0, 0.0, angle})};
    std::vector<Point<3>> line, there, about_it;
    for (const double metres : {0.0, 10.0, 40.0, 50.0}) {
      line.push_back({metres, 2.0 * metres, 0.0});
      there.push_back(transform(motion, line.back()));
      const double aside = metres == 0.0 || metres == 50.0 ? 0.1 : -0.1;  // on average on the line, and as far along it
      about_it.push_back(there.back() + Point<3>(0.0, 0.0, aside));
    }
    EXPECT_FALSE(rigid_alignment<3>(line, there));
    for (const auto& to : {there, about_it}) {
      const auto aligned = least_turning_alignment<3>(line, to);
      ASSERT_TRUE(aligned);
      EXPECT_LT(local(*aligned, motion).norm(), 1e-4);
    }
    const auto back = least_turning_alignment<3>(about_it, line);
    ASSERT_TRUE(back);
    EXPECT_LT(local(compose(*back, motion), Pose<3>{}).norm(), 1e-4);
  }
  EXPECT_FALSE(least_turning_alignment<3>({}, {}));
  EXPECT_FALSE(least_turning_alignment<3>({{1.0, 1.0, 1.0}}, {{2.0, 2.0, 2.0}}));
}

TYPED_TEST(AlignmentTest, TurnsLeastWherePointsTellAllAsTheyTell) {
  const auto points = this->scattered(12);
  const auto there = this->moved(points, 0.1);
  EXPECT_EQ(local(*least_turning_alignment(points, there), *rigid_alignment(points, there)).norm(), 0.0);
}

TYPED_TEST(AlignmentTest, TriesTheFirstTheMiddleAndTheLastOfSharedPoses) {
  constexpr int kDim = TestFixture::kDim;
  Correspondences<kDim> correspondences;
  for (int k = 0; k < 5; ++k) {
    correspondences.add_pose(this->random_.template pose<kDim>(4.0, 2.0), this->random_.template pose<kDim>(4.0, 2.0));
  }
  const auto tries = correspondences.candidates();
  ASSERT_EQ(tries.size(), 4u);  // three shared poses, and all of them as points
  for (const auto& [k, pose] : {std::pair{0u, 0u}, {1u, 2u}, {2u, 4u}}) {
    EXPECT_EQ(local(tries[k], correspondences.alignments[pose]).norm(), 0.0);
    const auto is_this = [&, k = k](const Pose<kDim>& alignment) { return local(alignment, tries[k]).norm(); };
    EXPECT_EQ(local(cheapest_alignment<kDim>(tries, is_this), tries[k]).norm(), 0.0);
  }
}

TYPED_TEST(AlignmentTest, TakesARobotThatIsSeenForAPointWhereverItHeads) {
  constexpr int kDim = TestFixture::kDim;
  PoseFactor<kDim> seen{0, 1, Pose<kDim>{}, PoseMatrix<kDim>::Identity()};
  seen.information.template bottomRightCorner<kRotationDof<kDim>, kRotationDof<kDim>>().setZero();
  const Pose<kDim> second_in_first = this->random_.template pose<kDim>(5.0, 2.0);
  Correspondences<kDim> correspondences;
  for (const auto& point : this->scattered(6)) {
    Pose<kDim> as_measured = this->random_.template pose<kDim>(0.0, 2.0);
    Pose<kDim> as_mapped = this->random_.template pose<kDim>(0.0, 2.0);
    as_measured.translation = transform(second_in_first, point);
    as_mapped.translation = point;
    correspondences.add_closure(seen, as_measured, as_mapped);
  }
  const auto tries = correspondences.candidates();
  ASSERT_EQ(tries.size(), 1u);
  EXPECT_LT(local(tries.front(), second_in_first).norm(), 1e-9);
}

TYPED_TEST(AlignmentTest, TakesFromAClosureThatLeavesThePositionFreeTheRotationOnlyForWantOfAllElse) {
  constexpr int kDim = TestFixture::kDim;
  PoseFactor<kDim> turned{0, 1, Pose<kDim>{}, PoseMatrix<kDim>::Identity()};
  turned.information(0, 0) = 0.0;
  const Pose<kDim> second_in_first = this->random_.template pose<kDim>(5.0, 2.0);
  Pose<kDim> elsewhere = second_in_first;
  elsewhere.translation[0] += 1e3;
  Correspondences<kDim> correspondences;
  correspondences.add_closure(turned, elsewhere, Pose<kDim>{});
  const auto turn = correspondences.candidates();
  ASSERT_EQ(turn.size(), 1u);
  EXPECT_LT(local(turn.front(), elsewhere).norm(), 1e-9);
  for (const auto& point : this->scattered(6)) correspondences.add_point(transform(second_in_first, point), point);
  const auto tries = correspondences.candidates();
  ASSERT_EQ(tries.size(), 1u);
  EXPECT_LT(local(tries.front(), second_in_first).norm(), 1e-9);
  Correspondences<kDim> of_nothing;
  turned.information.setZero();
  of_nothing.add_closure(turned, elsewhere, Pose<kDim>{});
  EXPECT_TRUE(of_nothing.first_points.empty());
  EXPECT_TRUE(of_nothing.candidates().empty());
}

/// Two partial maps that share a pose and a feature; each sees the shared feature and one of its own from both its poses.
TYPED_TEST(AlignmentTest, SharedFactorsWeighWhatAlignmentsChange) {
  constexpr int kDim = TestFixture::kDim;
  std::vector<FeatureFactor<kDim>> observations;
  for (const int pose : {0, 1, 1, 2}) {
    for (const int feature : {0, observations.size() < 4 ? 1 : 2}) {
      observations.push_back({PoseIndex(pose), FeatureIndex(feature), this->random_.template vector<kDim>(3.0),
                              this->random_.template information<kDim>()});
    }
  }
  PartialMap<kDim> a;
  PartialMap<kDim> b;
  a.poses = {0, 1};
  a.features = {0, 1};
  b.poses = {1, 2};
  b.features = {0, 2};
  for (PartialMap<kDim>* partial : {&a, &b}) {
    for (int k = 0; k < 2; ++k) {
      partial->state.poses.push_back(this->random_.template pose<kDim>(4.0, 2.0));
      partial->state.features.push_back(this->random_.template vector<kDim>(4.0));
    }
  }
  for (std::size_t k = 0; k < observations.size(); ++k) (k < 4 ? a : b).factors.feature_factors.push_back(&observations[k]);
  const PoseFactor<kDim> edge{1, 2, this->random_.template pose<kDim>(), this->random_.template information<kPoseDof<kDim>>()};
  b.factors.pose_factors.push_back(&edge);

  const SharedFactors<kDim> shared(a, b, {});
  const Pose<kDim> first = this->random_.template pose<kDim>(4.0, 2.0);
  const Pose<kDim> second = this->random_.template pose<kDim>(4.0, 2.0);
  const double change = partial_map_chi2(merged(a, b, second)) - partial_map_chi2(merged(a, b, first));
  EXPECT_NEAR(shared.chi2(second) - shared.chi2(first), change, 1e-9 * partial_map_chi2(merged(a, b, second)));
  EXPECT_GT(std::abs(change), 1e-3);
}

TYPED_TEST(AlignmentTest, SharedFactorsWeighTheirThousandSpreadEvenly) {
  constexpr int kDim = TestFixture::kDim;
  PartialMap<kDim> a{{0}, {}, {{Pose<kDim>{}}, {}}, {}};
  PartialMap<kDim> b{{1}, {}, {{Pose<kDim>{}}, {}}, {}};
  PoseFactor<kDim> fits{0, 1, Pose<kDim>{}, PoseMatrix<kDim>::Identity()};
  PoseFactor<kDim> misfits = fits;
  misfits.measured.translation[0] = 1.0;
  std::vector<const PoseFactor<kDim>*> closures(3000, &fits);
  std::fill(closures.begin() + 2000, closures.end(), &misfits);
  const double weighed = SharedFactors<kDim>(a, b, closures).chi2({});
  EXPECT_NEAR(weighed, static_cast<double>(SharedFactors<kDim>::kMost) / 3.0, 1.0);
  closures.resize(900, &fits);
  closures.back() = &misfits;
  EXPECT_EQ(SharedFactors<kDim>(a, b, closures).chi2({}), 1.0);
}

}  // namespace
}  // namespace mapjoin::testing
