// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/ids.hpp>
#include <tests/support/data.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/large_simulation.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::data_file;
using testing::small_world;

template <typename D>
class ConsistencyTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;

  static RunOptions options(bool polish = true) {
    RunOptions options;
    options.split = {SplitRule::kPoses, 7.0};
    options.polish = polish;
    options.covariances = true;
    return options;
  }
  static Truth<kDim> all_of(const Values<kDim>& truth) {
    Truth<kDim> known;
    known.poses.assign(truth.poses.begin(), truth.poses.end());
    known.features.assign(truth.features.begin(), truth.features.end());
    return known;
  }
  /// The NEES eᵀ P⁻¹ e of some poses and features, by their joint covariance as a dense matrix.
  static double dense_nees(const RunResult<kDim>& result, const Values<kDim>& truth, const std::vector<PoseOrFeature>& of) {
    std::vector<double> errors;
    const auto append = [&](const Eigen::VectorXd& e) { errors.insert(errors.end(), e.begin(), e.end()); };
    for (const auto& v : of) {
      if (const auto* p = std::get_if<PoseIndex>(&v)) append(local(result.map.poses[*p], truth.poses[*p]));
      if (const auto* f = std::get_if<FeatureIndex>(&v)) append(truth.features[*f] - result.map.features[*f]);
    }
    const Eigen::Map<Eigen::VectorXd> e(errors.data(), static_cast<Eigen::Index>(errors.size()));
    return e.dot(result.covariances->joint(of).value().ldlt().solve(e));
  }
};
TYPED_TEST_SUITE(ConsistencyTest, testing::Dimensions);

TYPED_TEST(ConsistencyTest, WeighsErrorsByTheJointCovarianceOfTheSameThings) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>({.poses = 36, .features = 40, .range = 2.5});
  for (const bool polish : {true, false}) {
    const auto result = run(world.log, this->options(polish));
    ASSERT_TRUE(result) << result.error().message;
    const auto consistent = consistency(*result->covariances, this->all_of(world.truth));
    ASSERT_TRUE(consistent) << consistent.error().message;
    std::vector<PoseOrFeature> poses, features;
    for (PoseIndex p = 1; p < 36; ++p) poses.emplace_back(p);
    for (const FeatureIndex f : indices(world.log.features)) features.emplace_back(f);
    const auto expect = [&](const Nees& nees, const std::vector<PoseOrFeature>& of) {
      const double expected = this->dense_nees(*result, world.truth, of);
      EXPECT_NEAR(nees.value, expected, 1e-7 * expected) << polish;
    };
    EXPECT_EQ(consistent->poses.dimensions, static_cast<Eigen::Index>(poses.size()) * kPoseDof<kDim>);
    expect(consistent->poses, poses);
    expect(consistent->features, features);
    std::vector<PoseOrFeature> all = poses;
    all.insert(all.end(), features.begin(), features.end());
    expect(consistent->joint, all);
    EXPECT_EQ(consistent->joint.dimensions, consistent->poses.dimensions + consistent->features.dimensions);
  }
}

/// Quantiles from a table of the chi-squared distribution.
TEST(Nees, IsHeldAgainstQuantilesOfOnePercent) {
  const Nees nees{18.307, 10};
  EXPECT_NEAR(nees.least(), 2.558, 1e-3);
  EXPECT_NEAR(nees.most(), 23.209, 1e-3);
  EXPECT_NEAR(nees.probability(), 0.05, 1e-5);
}

TYPED_TEST(ConsistencyTest, TakesTheFrameOfTheTruthFromThePoseThatHoldsTheMap) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>();
  const auto result = run(world.log, this->options());
  ASSERT_TRUE(result);
  const Values<kDim> elsewhere = moved(testing::Random(4).pose<kDim>(), world.truth);
  const auto here = consistency(*result->covariances, this->all_of(world.truth));
  const auto there = consistency(*result->covariances, this->all_of(elsewhere));
  ASSERT_TRUE(here && there);
  EXPECT_NEAR(here->joint.value, there->joint.value, 1e-6 * here->joint.value);
}

TYPED_TEST(ConsistencyTest, CountsWhatIsKnownOnly) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>();
  const auto result = run(world.log, this->options());
  ASSERT_TRUE(result);
  Truth<kDim> some = this->all_of(world.truth);
  std::fill(some.features.begin(), some.features.end(), std::nullopt);
  some.poses[5] = some.poses[17] = std::nullopt;
  const auto consistent = consistency(*result->covariances, some);
  ASSERT_TRUE(consistent);
  EXPECT_EQ(consistent->features.dimensions, 0);
  EXPECT_EQ(consistent->poses.dimensions, (40 - 1 - 2) * kPoseDof<kDim>);
  EXPECT_EQ(consistent->joint.value, consistent->poses.value);

  some.poses[0] = std::nullopt;
  const auto unplaced = consistency(*result->covariances, some);
  ASSERT_TRUE(unplaced) << unplaced.error().message;
  EXPECT_EQ(unplaced->joint.dimensions, 0);

  std::fill(some.poses.begin(), some.poses.end(), std::nullopt);
  const auto unknown = consistency(*result->covariances, some);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().kind, ErrorKind::kUsage);
}

TEST(ConsistencyDataTest, OfTheLargeSimulationIsWithinItsGates) {
  const auto any = read_local_map_set(data_file("sim-35188/localmaps_mat.tar.gz"));
  ASSERT_TRUE(any) << any.error().message;
  const auto& set = std::get<SubmapSet<2>>(*any);
  RunOptions options;
  options.covariances = true;
  const auto result = run(set, options);
  ASSERT_TRUE(result) << result.error().message;
  const auto consistent = consistency(*result->covariances, testing::truth_of_simulation(set));
  ASSERT_TRUE(consistent) << consistent.error().message;
  EXPECT_EQ(consistent->joint.dimensions, 10504);
  EXPECT_NEAR(consistent->joint.value, 9961.0, 1.0);
  EXPECT_NEAR(consistent->joint.most(), 10844.0, 1.0);
  EXPECT_EQ(consistent->features.dimensions, 8404);
  EXPECT_NEAR(consistent->features.value, 7821.0, 1.0);
  EXPECT_NEAR(consistent->features.most(), 8709.0, 1.0);
  EXPECT_LT(consistent->poses.value, consistent->poses.most());
}

}  // namespace
}  // namespace mapjoin
