// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/covariances/relations.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/support/dense_information.hpp>
#include <tests/support/dense_relations.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::DenseInformation;
using testing::largest_difference;

/// The gauge of the map.
enum class Anchor { kFirstPose, kLaterPoses, kPriors };

template <typename D>
class RelationsTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;

  /// A log of two robots that features alone tie to each other, some odometry stored against its direction.
  static Log<kDim> world(Anchor anchor) {
    auto small = testing::small_world<kDim>(
        {.poses = 18, .features = 24, .closures = 2, .sessions = 2, .range = 3.0, .reversed_odometry = true});
    if (anchor == Anchor::kLaterPoses) small.log.graph.fixed = {{9, small.truth.poses[9]}, {14, small.truth.poses[14]}};
    if (anchor == Anchor::kPriors) {
      testing::Random random(5);
      small.log.graph.pose_factors.push_back({kWorld, 7, small.truth.poses[7], 1e2 * random.information<kDof>()});
    }
    return small.log;
  }
  static RunResult<kDim> map_of(const Log<kDim>& log, double poses_per_map) {
    RunOptions options;
    options.split = {SplitRule::kPoses, poses_per_map};
    options.covariances = options.marginals = true;
    return poses_per_map > 1.0 ? run(log, options).value() : solve(log, options).value();
  }
};
TYPED_TEST_SUITE(RelationsTest, testing::Dimensions);

TYPED_TEST(RelationsTest, ComposeToTheMapFromParentsToChildren) {
  for (const Anchor anchor : {Anchor::kFirstPose, Anchor::kLaterPoses, Anchor::kPriors}) {
    for (const double poses_per_map : {1.0, 6.0}) {
      const auto result = this->map_of(this->world(anchor), poses_per_map);
      const auto& relations = result.marginals.value().relations;
      EXPECT_LT(largest_difference(composed(relations), {result.map.poses, result.map.features}), 1e-9);
      Table<PoseIndex, bool> stands(result.map.poses.size(), false);
      for (const PoseIndex pose : relations.order) {
        const PoseIndex parent = relations.poses[pose].parent;
        EXPECT_TRUE(parent == kWorld || stands[parent]);
        EXPECT_FALSE(stands[pose]);
        stands[pose] = true;
      }
      EXPECT_EQ(std::count(stands.begin(), stands.end(), true), std::ssize(stands));
    }
  }
}

TYPED_TEST(RelationsTest, LeadAlongTheRobotsWay) {
  const auto result = this->map_of(this->world(Anchor::kFirstPose), 6.0);
  const auto& relations = result.marginals.value().relations;
  for (PoseIndex pose = 0; pose < 36; ++pose) {
    const PoseIndex parent = relations.poses[pose].parent;
    const bool is_root = pose.value % 18 == 0;
    EXPECT_EQ(parent == kWorld, is_root) << pose.value;
    EXPECT_TRUE(is_root || (parent < pose && parent >= pose - 6)) << pose.value;
  }
  for (const auto& relation : relations.features) EXPECT_NE(relation.parent, kWorld);
}

TYPED_TEST(RelationsTest, HaveTheCovariancesOfTheInformationInRelativeCoordinates) {
  constexpr int kDim = TestFixture::kDim;
  for (const Anchor anchor : {Anchor::kFirstPose, Anchor::kLaterPoses, Anchor::kPriors}) {
    const auto log = this->world(anchor);
    for (const double poses_per_map : {1.0, 6.0}) {
      const auto result = this->map_of(log, poses_per_map);
      const Values<kDim> state{result.map.poses, result.map.features};
      DenseInformation<kDim> dense(state);
      for (const auto& o : log.graph.pose_factors) dense.add(o);
      for (const auto& o : log.observations()) dense.add(o);
      testing::expect_relations_of(dense, result.map.gauge, result.marginals.value().relations);
    }
  }
}

TYPED_TEST(RelationsTest, AreMoreCertainThanPositionsOfDeadReckoning) {
  const auto small = testing::small_world<TestFixture::kDim>({.poses = 30, .features = 0, .closures = 0});
  const auto result = this->map_of(small.log, 6.0);
  const auto& marginals = result.marginals.value();
  EXPECT_LT(9.0 * marginals.relations.poses.back().covariance.trace(), marginals.poses.back().trace());
}

TYPED_TEST(RelationsTest, AreInterruptedWithTheMarginals) {
  const auto result = this->map_of(this->world(Anchor::kFirstPose), 6.0);
  std::stop_source stop;
  std::vector<std::size_t> told;
  const auto progress = [&](std::size_t done, std::size_t to_do) {
    EXPECT_LE(done, to_do);
    told.push_back(done);
    if (told.size() == 3) stop.request_stop();
  };
  const auto marginals = result.covariances->marginals(progress, stop.get_token());
  ASSERT_FALSE(marginals);
  EXPECT_EQ(marginals.error().kind, ErrorKind::kInterrupted);
  EXPECT_EQ(told, (std::vector<std::size_t>{0, 1, 2}));
}

}  // namespace
}  // namespace mapjoin
