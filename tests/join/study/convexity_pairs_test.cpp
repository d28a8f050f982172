// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <mapjoin/join/study/convexity_objective.hpp>
#include <mapjoin/join/study/convexity_pairs.hpp>
#include <tests/join/study/posed_world.hpp>
#include <tests/support/dimensions.hpp>

namespace mapjoin {
namespace {

using testing::largest_difference;
using testing::PosedWorld;

template <typename D>
class StateSamplerTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  StateSampler<kDim> sampler(StateSource source, double spread = 1.0) {
    return {source, spread, world_.composed, world_.system(), world_.state()};
  }

  PosedWorld<kDim> world_{testing::small_world<kDim>({.poses = 30, .features = 12}).log};
};
TYPED_TEST_SUITE(StateSamplerTest, testing::Dimensions);

TYPED_TEST(StateSamplerTest, GivesTheSameForTheSameSeedAndKeepsWhatIsHeld) {
  for (const StateSource source : {StateSource::kBox, StateSource::kDrift}) {
    const auto sampler = this->sampler(source);
    EXPECT_EQ(largest_difference(sampler.draw(4), sampler.draw(4)), 0.0);
    EXPECT_GT(largest_difference(sampler.draw(4), sampler.draw(5)), 1e-3);
    EXPECT_EQ(local(sampler.draw(4).poses[0], this->world_.state().poses[0]).norm(), 0.0);
  }
}

TYPED_TEST(StateSamplerTest, FillsTheBoxOfTheComposedStart) {
  constexpr int kDim = TestFixture::kDim;
  Eigen::AlignedBox<double, kDim> box, drawn;
  for (const auto& pose : this->world_.state().poses) box.extend(pose.translation);
  for (const auto& feature : this->world_.state().features) box.extend(feature);
  const auto sampler = this->sampler(StateSource::kBox);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Values<kDim> state = sampler.draw(seed);
    for (const auto& pose : state.poses) drawn.extend(pose.translation);
    for (const PoseIndex p : indices(state.poses)) {
      EXPECT_LE((this->world_.state().poses[p].rotation.inverse() * state.poses[p].rotation).log().norm(), 3.1416);
    }
  }
  EXPECT_TRUE(box.contains(drawn));
  EXPECT_GT(drawn.volume(), 0.8 * box.volume());
}

/// The mean of rᵀWr over the measurements of the tree is their number of rows times the squared spread.
TYPED_TEST(StateSamplerTest, DriftsByTheStatedCovariances) {
  constexpr int kDim = TestFixture::kDim;
  for (const double poses_per_map : {1.0, 6.0}) {
    PosedWorld<kDim> world(testing::small_world<kDim>({.poses = 30, .features = 12, .closures = 0, .range = 2.0}).log,
                           poses_per_map);
    constexpr double kSpread = 0.3;
    const StateSampler<kDim> sampler(StateSource::kDrift, kSpread, world.composed, world.system(), world.state());
    const RelativeCoordinates<kDim> relative(world.system(), world.state());
    const auto poses = static_cast<Eigen::Index>(relative.tree().poses.size());
    double sum = 0.0;
    constexpr int kDraws = 400;
    for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
      const Eigen::VectorXd x = relative.of(sampler.draw(seed));
      for (Eigen::Index e = 0; e < poses; ++e) {
        const auto [factor, target, child_is_base] = *relative.tree().poses[static_cast<std::size_t>(e)].observation;
        const auto [kind, place] = world.system().source_of(factor);
        Eigen::MatrixXd W;
        if (kind == JoiningSystem<kDim>::Source::kMap) {
          const auto& map = *world.system().maps()[place].map;
          const Eigen::MatrixXd P = map.information.inverse();
          W = P.block(map.row(target), map.row(target), kPoseDof<kDim>, kPoseDof<kDim>).inverse();
        } else {
          W = world.system().pose_factors()[place].observation->information;
        }
        const Eigen::VectorXd own = x.segment(e * kPoseDof<kDim>, kPoseDof<kDim>);
        sum += own.dot(W * own);
      }
    }
    const double expected = kSpread * kSpread * static_cast<double>(poses * kPoseDof<kDim>);
    EXPECT_NEAR(sum / kDraws, expected, 0.05 * expected);
  }
}

}  // namespace
}  // namespace mapjoin
