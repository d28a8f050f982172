// SPDX-License-Identifier: BSD-3-Clause
// Public logs by open_log(): counts as their README gives them, and each form of a log against the others.
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <stdexcept>
#include <string>
#include <tests/support/data.hpp>

namespace mapjoin {
namespace {

template <int Dim>
Log<Dim> open(const std::string& file) {
  auto log = open_log(testing::data_file(file));
  if (!log) throw std::runtime_error(log.error().message);
  return std::get<Log<Dim>>(*std::move(log));
}

template <int Dim>
void expect_counts(const Log<Dim>& log, std::size_t poses, std::size_t features, std::size_t odometry, std::size_t closures,
                   std::size_t observations) {
  EXPECT_EQ(log.poses.size(), poses);
  EXPECT_EQ(log.features.size(), features);
  EXPECT_EQ(log.odometry().size(), odometry);
  EXPECT_EQ(log.closures().size(), closures);
  EXPECT_EQ(log.observations().size(), observations);
}

/// Expects the same poses, the same features (their keys in `b` larger by `first_feature`), and the same odometry and
/// observations up to the relative `precision`.
void expect_same(const Log<2>& a, const Log<2>& b, double precision, std::uint64_t first_feature = 0) {
  ASSERT_EQ(a.poses, b.poses);
  ASSERT_EQ(a.features.size(), b.features.size());
  for (const FeatureIndex i : indices(a.features)) EXPECT_EQ(a.features[i].key + first_feature, b.features[i].key);
  ASSERT_EQ(a.odometry().size(), b.odometry().size());
  for (std::size_t i = 0; i < a.odometry().size(); ++i) {
    EXPECT_EQ(a.odometry()[i].base, b.odometry()[i].base);
    EXPECT_EQ(a.odometry()[i].target, b.odometry()[i].target);
    EXPECT_LE(local(a.odometry()[i].measured, b.odometry()[i].measured).norm(), precision);
    EXPECT_TRUE(a.odometry()[i].information.isApprox(b.odometry()[i].information, precision)) << i;
  }
  ASSERT_EQ(a.observations().size(), b.observations().size());
  for (std::size_t i = 0; i < a.observations().size(); ++i) {
    EXPECT_EQ(a.observations()[i].base, b.observations()[i].base);
    EXPECT_EQ(a.observations()[i].target, b.observations()[i].target);
    EXPECT_TRUE(a.observations()[i].measured.isApprox(b.observations()[i].measured, precision));
    EXPECT_TRUE(a.observations()[i].information.isApprox(b.observations()[i].information, precision)) << i;
  }
}

TEST(OpenLogData, VictoriaParkIsTheSameAsMatAsTextAndAsG2o) {
  const auto mat = open<2>("vicpark-6898/VicPark_clean_data.mat");
  expect_counts(mat, 6899, 299, 6898, 0, 45390);
  expect_same(mat, open<2>("vicpark-6898/vicpark_clean_data.txt.gz"), 0.0);
  expect_same(mat, open<2>("vicpark-6898/vicpark6898.g2o.gz"), 1e-12, 100000);
}

TEST(OpenLogData, CorrectedDlrIsTheSameAsMatAsTextAndAsG2o) {
  const auto mat = open<2>("dlr/corrected_data_circles.mat");
  expect_counts(mat, 3298, 549, 3297, 0, 14184);
  EXPECT_EQ(mat.unassociated, 436);
  const auto text = open<2>("dlr/dlr_corrected.txt.gz");
  EXPECT_EQ(text.unassociated, 436);
  expect_same(mat, text, 0.0);
  expect_same(mat, open<2>("dlr/dlr_corrected.g2o.gz"), 1e-12, 100000);
}

TEST(OpenLogData, OriginalDlrIsMapCirclesWithoutItsFirstStep) {
  const auto circles = open<2>("dlr/map.circles.gz");
  expect_counts(circles, 3298, 576, 3297, 0, 14309);
  EXPECT_EQ(circles.unassociated, 436);
  const auto g2o = open<2>("dlr/dlr.g2o.gz");
  expect_counts(g2o, 3297, 576, 3296, 0, 14309);
  for (std::size_t i = 0; i < g2o.odometry().size(); ++i) {
    EXPECT_LT(local(circles.odometry()[i + 1].measured, g2o.odometry()[i].measured).norm(), 2e-6);
    EXPECT_TRUE(circles.odometry()[i + 1].information.isApprox(g2o.odometry()[i].information, 1e-5)) << i;
  }
}

TEST(OpenLogData, CityTreesKeepPosesAndFeaturesApart) {
  expect_counts(open<2>("citytrees10000/cityTrees10000.txt"), 10000, 100, 9999, 0, 4443);
  expect_counts(open<2>("citytrees10000/montecarlo/cityTrees10000_3.txt.gz"), 10000, 100, 9999, 0, 4443);
}

TEST(OpenLogData, ToriAreReadFromIsam) {
  expect_counts(open<3>("torus2000points/torus2000Points.txt"), 1073, 20, 1072, 962, 1039);
  const auto torus = open<3>("pose-graphs-3d/torus10000_isam.txt.gz");
  EXPECT_EQ(torus.poses.size(), 10000u);
  EXPECT_EQ(torus.odometry().size() + torus.closures().size(), 22280u);
}

TEST(OpenLogData, SphereInIsamsEulerAnglesClosesOnItself) {
  // The edges of the ground truth have no noise: composed odometry must agree with every closure.
  const auto log = open<3>("pose-graphs-3d/sphere2500_groundtruth.txt.gz");
  Table<PoseIndex, Pose<3>> poses(log.poses.size());
  for (const auto& edge : log.odometry()) {
    poses[edge.target] = compose(poses[edge.base], edge.measured);
  }
  ASSERT_GT(log.closures().size(), 2000u);
  for (const auto& edge : log.closures()) {
    const auto found = between(poses[edge.base], poses[edge.target]);
    EXPECT_LT(local(edge.measured, found).norm(), 1e-2);
  }
}

}  // namespace
}  // namespace mapjoin
