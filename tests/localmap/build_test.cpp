// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/localmap/build.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::DenseSlam;
using testing::small_world;

template <typename D>
class BuildTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr Eigen::Index kDof = kPoseDof<kDim>;

  /// The segment as a dense problem over the whole log's state: interior poses, then kept ones, then features.
  static DenseSlam<kDim> dense(const SegmentView<kDim>& view) {
    DenseSlam<kDim> slam;
    slam.pose_factors.assign(view.odometry.begin(), view.odometry.end());
    slam.feature_factors.assign(view.observations.begin(), view.observations.end());
    slam.free_poses = view.interior;
    slam.free_poses.insert(slam.free_poses.end(), view.kept.begin(), view.kept.end());
    slam.free_features = view.features;
    return slam;
  }
  /// The truth in the frame of the pose `base`.
  static Values<kDim> seen_from(PoseIndex base, const Values<kDim>& truth) { return moved(inverse(truth.pose(base)), truth); }

  testing::SmallWorld<kDim> world = small_world<kDim>({.reversed_odometry = true});
  Split parts = split(world.log, {SplitRule::kPoses, 9.0});
};
TYPED_TEST_SUITE(BuildTest, testing::Dimensions);

TYPED_TEST(BuildTest, ALocalMapIsTheMarginalOfTheDenseSolutionOfItsSegment) {
  constexpr int kDim = TestFixture::kDim;
  for (const Segment& segment : this->parts.segments) {
    ASSERT_TRUE(segment.is_map);
    const SegmentView<kDim> view = segment_view(this->world.log, this->parts, segment);
    const auto slam = this->dense(view);
    const Values<kDim> optimum = slam.optimum(this->seen_from(view.begin, this->world.truth));
    const auto equations = slam.linearise(optimum);
    const Eigen::Index chain = static_cast<Eigen::Index>(view.interior.size()) * this->kDof;
    std::vector<Eigen::Index> out(static_cast<std::size_t>(chain));
    std::iota(out.begin(), out.end(), 0);
    std::vector<Eigen::Index> stay(static_cast<std::size_t>(slam.size() - chain));
    std::iota(stay.begin(), stay.end(), chain);
    const Eigen::MatrixXd W = eliminated(equations, out, stay).H;

    const auto built = build_local_map(view, {});
    ASSERT_TRUE(built.map);
    const LocalMap<kDim>& map = *built.map;
    EXPECT_EQ(map.base, segment.begin);
    EXPECT_EQ(map.poses, view.kept);
    EXPECT_EQ(map.features, view.features);
    EXPECT_NEAR(map.chi2, equations.chi2, 1e-6 * equations.chi2);
    EXPECT_LT((map.information - W).norm(), 1e-5 * W.norm());
    EXPECT_EQ((map.information - map.information.transpose()).norm(), 0.0);
    for (std::size_t p = 0; p < map.poses.size(); ++p) {
      EXPECT_LT(local(map.pose_estimates[p], optimum.pose(map.poses[p])).norm(), 1e-6);
    }
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      EXPECT_LT((map.feature_estimates[f] - optimum.features[map.features[f]]).norm(), 1e-6);
    }
  }
}

TYPED_TEST(BuildTest, AMapOfOdometryAloneIsTheComposedMeasurement) {
  constexpr int kDim = TestFixture::kDim;
  const auto corridor = small_world<kDim>({.poses = 3, .features = 0, .closures = 0});
  Split parts = split(corridor.log, {SplitRule::kPoses, 2.0});
  const auto maps = build_local_maps<kDim>(corridor.log, parts, {});
  ASSERT_EQ(maps->maps.size(), 1u);
  const Pose<kDim> composed = compose(corridor.log.odometry()[0].measured, corridor.log.odometry()[1].measured);
  EXPECT_LT(local(maps->maps[0].pose_estimates[0], composed).norm(), 1e-12);
  EXPECT_LT(maps->maps[0].chi2, 1e-20);
}

TYPED_TEST(BuildTest, MapsComeInTheOrderOfTheirSegments) {
  constexpr int kDim = TestFixture::kDim;
  std::size_t last_done = 0;
  BuildOptions options;
  options.progress = [&](std::size_t done, std::size_t to_do) {
    EXPECT_EQ(done, last_done + 1);
    EXPECT_EQ(to_do, this->parts.segments.size());
    last_done = done;
  };
  const auto maps = build_local_maps<kDim>(this->world.log, this->parts, options);
  ASSERT_TRUE(maps);
  ASSERT_EQ(maps->maps.size(), this->parts.segments.size());
  EXPECT_EQ(last_done, maps->maps.size());
  EXPECT_GT(maps->iterations, 0);
  for (std::size_t k = 0; k < maps->maps.size(); ++k) EXPECT_EQ(maps->maps[k].base, this->parts.segments[k].begin);
}

TYPED_TEST(BuildTest, ASegmentThatItsOwnObservationsDoNotDetermineStaysRaw) {
  constexpr int kDim = TestFixture::kDim;
  // A step without information on its length, which only other maps could determine.
  auto& step = this->world.log.graph.pose_factors[10];
  step.information.row(0).setZero();
  step.information.col(0).setZero();
  std::erase_if(this->world.log.graph.feature_factors, [](const auto& o) { return o.base >= 9 && o.base <= 18; });
  Split parts = split(this->world.log, {SplitRule::kPoses, 9.0});
  ASSERT_TRUE(parts.segments[1].is_map);
  const auto maps = build_local_maps<kDim>(this->world.log, parts, {});
  ASSERT_TRUE(maps);
  EXPECT_FALSE(parts.segments[1].is_map);
  EXPECT_EQ(maps->maps.size(), parts.segments.size() - 1);
  EXPECT_EQ(std::count(parts.kept.begin() + 9, parts.kept.begin() + 19, true), 10);
}

TYPED_TEST(BuildTest, ASplitOfAnotherLogIsBadInput) {
  constexpr int kDim = TestFixture::kDim;
  Split longer = this->parts;
  longer.segments.back().end = 5000;
  Split reversed = this->parts;
  std::swap(reversed.segments[0].begin, reversed.segments[0].end);
  Split keeps_nothing = this->parts;
  keeps_nothing.kept.clear();
  for (Split* wrong : {&longer, &reversed, &keeps_nothing}) {
    const auto maps = build_local_maps<kDim>(this->world.log, *wrong, {});
    ASSERT_FALSE(maps);
    EXPECT_EQ(maps.error().kind, ErrorKind::kBadInput);
  }
}

TYPED_TEST(BuildTest, TheSolveOfAMapEndsOnceAStopIsRequested) {
  constexpr int kDim = TestFixture::kDim;
  std::stop_source stop;
  stop.request_stop();
  const SegmentView<kDim> view = segment_view(this->world.log, this->parts, this->parts.segments.front());
  const BuiltMap<kDim> built = build_local_map(view, {}, stop.get_token());
  EXPECT_FALSE(built.map);
  EXPECT_EQ(built.iterations, 0);
}

TYPED_TEST(BuildTest, StopsWhereAskedTo) {
  constexpr int kDim = TestFixture::kDim;
  std::stop_source stop;
  stop.request_stop();
  const auto maps = build_local_maps<kDim>(this->world.log, this->parts, {}, stop.get_token());
  ASSERT_FALSE(maps);
  EXPECT_EQ(maps.error().kind, ErrorKind::kInterrupted);
}

}  // namespace
}  // namespace mapjoin
