// SPDX-License-Identifier: BSD-3-Clause
// Logs with priors of poses and features, as g2o files have them, against the optimum of Ceres.
#include <gtest/gtest.h>

#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <numbers>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <tests/support/temporary_folder.hpp>
#include <utility>

namespace mapjoin::testing {
namespace {

template <typename D>
class Priors : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// The log of `world` in a random frame, written to a file and read from it, with priors of positions, of a whole pose and of
  /// features.
  static Log<kDim> log_from_file(const SmallWorld<kDim>& world) {
    Random random(7);
    const Pose<kDim> frame = random.pose<kDim>(100.0, 1.0);
    const Values<kDim> truth = moved(frame, world.truth);
    LogBuilder<kDim> builder("priors");
    builder.append(world.log);
    PoseMatrix<kDim> position = PoseMatrix<kDim>::Zero();
    position.template topLeftCorner<kDim, kDim>() = 10.0 * random.information<kDim>();
    for (const PoseIndex p : indices(world.log.poses)) {
      const Point<kDim> fix = truth.poses[p].translation + random.vector<kDim>(0.5);
      if (p.value % 5 == 0) builder.add_pose_prior(world.log.poses[p], {fix, {}}, position);
    }
    builder.add_pose_prior(world.log.poses.back(), truth.poses.back(), random.information<kPoseDof<kDim>>());
    for (const FeatureIndex f : indices(world.log.features)) {
      if (f.value % 10 != 0) continue;
      builder.add_feature_prior(world.log.features[f], truth.features[f] + random.vector<kDim>(0.3),
                                random.information<kDim>());
    }
    const TemporaryFolder folder;
    if (!write_g2o(std::move(builder).finish().value(), folder.path() / "log")) throw std::runtime_error("not written");
    return std::get<Log<kDim>>(read_g2o(TextScanner("log", content_of(folder.path() / "log")), {}).value());
  }

  static void expect_the_optimum(const Log<kDim>& log) {
    const auto joined = run(log, RunOptions{}).value();
    EXPECT_TRUE(joined.converged());
    EXPECT_TRUE(joined.map.gauge.empty()) << "the priors hold the map";
    const auto ceres = ceres_optimum(log, Values<kDim>{joined.map.poses, joined.map.features});
    EXPECT_NEAR(joined.chi2, ceres.chi2, 1e-8 * ceres.chi2);
    EXPECT_GT(joined.chi2, 1.0);
  }
};
TYPED_TEST_SUITE(Priors, Dimensions);

TYPED_TEST(Priors, MeasureAsMuchWithIdentityCovariances) {
  auto log = this->log_from_file(small_world<TypeParam::value>());
  const auto original = run(log, RunOptions{}).value();
  use_identity_covariance(log);
  EXPECT_EQ(run(log, RunOptions{}).value().dof, original.dof) << "a prior of a position says nothing of the rotation";
}

TYPED_TEST(Priors, OfAFileLeadToTheOptimum) {
  this->expect_the_optimum(this->log_from_file(small_world<TypeParam::value>()));
}

TYPED_TEST(Priors, TieSessionsThatShareNothing) {
  this->expect_the_optimum(this->log_from_file(small_world<TypeParam::value>({.features = 0, .sessions = 2})));
}

/// A straight drive in space that leads back along x, held by positions on a line and by an inclinometer: the start ahead of
/// all is a saddle, from which no step turns the map.
TEST(PriorsOnALine, LeadToTheOptimumOfADriveThatHeadsBack) {
  LogBuilder<3> builder("drive back");
  const PoseMatrix<3> of_odometry = 400.0 * PoseMatrix<3>::Identity();
  PoseMatrix<3> of_position = PoseMatrix<3>::Zero();
  of_position.topLeftCorner<3, 3>() = 4.0 * PointMatrix<3>::Identity();
  PoseMatrix<3> of_inclination = PoseMatrix<3>::Zero();
  of_inclination.diagonal()[3] = of_inclination.diagonal()[4] = 1e4;
  const Rotation<3> back = Rotation<3>::exp({0.0, 0.0, std::numbers::pi});
  for (std::uint64_t k = 0; k < 50; ++k) {
    builder.add_pose_edge({0, k}, {0, k + 1}, {{1.0, 0.0, 0.0}, {}}, of_odometry);
    if (k % 5 == 0) builder.add_pose_prior({0, k}, {{1000.0 - static_cast<double>(k), 1000.0, 0.0}, {}}, of_position);
  }
  builder.add_pose_prior({0, 0}, {Point<3>::Zero(), back}, of_inclination);
  const auto joined = run(std::move(builder).finish().value(), {}).value();
  EXPECT_TRUE(joined.converged());
  EXPECT_LT(joined.chi2, 1e-9);
  EXPECT_LT(local(joined.map.poses.front(), Pose<3>{{1000.0, 1000.0, 0.0}, back}).norm(), 1e-6);
}

}  // namespace
}  // namespace mapjoin::testing
