// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/study/truth_errors.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using ::mapjoin::testing::Dimensions;
using ::mapjoin::testing::Random;

/// A map whose poses leave a rotation free: one in the plane, a straight line in space; and its truth, which is the same map
/// elsewhere.
template <typename Dimension>
class TruthErrorsTest : public ::testing::Test {
 protected:
  static constexpr int kDim = Dimension::value;

  TruthErrorsTest() {
    Random random(5);
    const Pose<kDim> motion = random.template pose<kDim>();
    for (int k = 0; k < (kDim == 2 ? 1 : 5); ++k) {
      map.poses.push_back({static_cast<double>(k) * Point<kDim>::UnitX(), Rotation<kDim>()});
      truth.poses.push_back(compose(motion, map.poses.back()));
    }
    for (int k = 0; k < 4; ++k) {
      map.features.push_back(random.template pose<kDim>().translation);
      truth.features.push_back(transform(motion, map.features.back()));
    }
  }

  GlobalMap<kDim> map;
  Truth<kDim> truth;
};
TYPED_TEST_SUITE(TruthErrorsTest, Dimensions);

TYPED_TEST(TruthErrorsTest, FeaturesAlignWhatPosesLeaveFree) {
  const AbsoluteErrors errors = absolute_errors(this->map, this->truth);
  EXPECT_EQ(errors.aligned_by, AlignedBy::kFeatures);
  EXPECT_EQ(errors.poses.rotation.count, this->map.poses.size());
  EXPECT_EQ(errors.features.count, 4U);
  for (const ErrorSummary& all : {errors.poses.translation, errors.poses.rotation, errors.features}) EXPECT_LT(all.max, 1e-7);
}

TYPED_TEST(TruthErrorsTest, NothingIsSaidOfWhatIsStillFree) {
  for (auto& feature : this->truth.features) feature.reset();
  const AbsoluteErrors errors = absolute_errors(this->map, this->truth);
  EXPECT_EQ(errors.aligned_by, AlignedBy::kTooLittle);
  EXPECT_EQ(errors.poses.translation.count, this->map.poses.size());
  EXPECT_LT(errors.poses.translation.max, 1e-9);
  EXPECT_EQ(errors.poses.rotation.count, 0U);
  EXPECT_EQ(errors.features.count, 0U);
  EXPECT_FALSE(alignment_onto(this->truth, this->map));
}

TYPED_TEST(TruthErrorsTest, AFirstPoseAlignsAll) {
  const AbsoluteErrors errors = absolute_errors(this->map, this->truth, TrajectoryAlignment::kOrigin);
  EXPECT_EQ(errors.aligned_by, AlignedBy::kPoses);
  EXPECT_LT(errors.poses.rotation.max, 1e-7);
  EXPECT_LT(errors.features.max, 1e-9);
}

TYPED_TEST(TruthErrorsTest, PosesAloneAlignWhereTheyDetermineTheMotion) {
  constexpr int kDim = TypeParam::value;
  for (int axis = 0; axis < kDim; ++axis) {
    this->map.poses.push_back({Point<kDim>::Unit(axis), Rotation<kDim>()});
    this->truth.poses.emplace_back(this->map.poses.back());
  }
  this->truth.poses.front().reset();
  this->truth.features.front() = Point<kDim>::Constant(1e3);
  EXPECT_EQ(absolute_errors(this->map, this->truth).aligned_by, AlignedBy::kPoses);
}

TYPED_TEST(TruthErrorsTest, SpansCountThePosesOfTheMap) {
  constexpr int kDim = TypeParam::value;
  GlobalMap<kDim> map;
  Truth<kDim> truth;
  for (int k = 0; k < 9; ++k) {
    map.poses.push_back({1.1 * k * Point<kDim>::UnitX(), Rotation<kDim>()});
    truth.poses.emplace_back();
    if (k % 4 == 0) truth.poses.back() = Pose<kDim>{static_cast<double>(k) * Point<kDim>::UnitX(), Rotation<kDim>()};
  }
  const auto over = [&](std::size_t span) { return relative_errors(map, truth, pairs_by_steps(9, span)).translation; };
  EXPECT_EQ(over(1).count, 0U);
  EXPECT_EQ(over(4).count, 2U);
  EXPECT_NEAR(over(4).max, 0.4, 1e-12);
}

}  // namespace
}  // namespace mapjoin
