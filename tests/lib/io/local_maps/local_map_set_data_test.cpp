// SPDX-License-Identifier: BSD-3-Clause
// Public sets of local maps: MAT files agree with text, and chi2 with the value of another program.
#include <gtest/gtest.h>

#include <map>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <tests/support/data.hpp>

namespace mapjoin {
namespace {

using testing::data_file;

template <int Dim>
SubmapSet<Dim> read(const std::filesystem::path& path) {
  auto set = read_local_map_set(path);
  EXPECT_TRUE(set) << set.error().message;
  return std::get<SubmapSet<Dim>>(*set);
}

/// Expects the same estimates, and the same W up to rounding relative to its diagonal.
template <int Dim>
void expect_equal(const LocalMap<Dim>& a, const LocalMap<Dim>& b) {
  ASSERT_EQ(a.base, b.base);
  ASSERT_EQ(a.poses, b.poses);
  ASSERT_EQ(a.features, b.features);
  for (std::size_t i = 0; i < a.poses.size(); ++i) EXPECT_EQ(local(a.pose_estimates[i], b.pose_estimates[i]).norm(), 0.0);
  EXPECT_EQ(a.feature_estimates, b.feature_estimates);
  const Eigen::VectorXd scale = a.information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd difference = scale.asDiagonal() * (a.information - b.information) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-12);
}

template <int Dim>
void expect_equal(const SubmapSet<Dim>& a, const SubmapSet<Dim>& b) {
  ASSERT_EQ(a.poses, b.poses);
  ASSERT_EQ(a.features, b.features);
  ASSERT_EQ(a.graph.submaps.size(), b.graph.submaps.size());
  for (std::size_t k = 0; k < a.graph.submaps.size(); ++k) expect_equal(a.graph.submaps[k], b.graph.submaps[k]);
}

/// The chi2 of the maps laid end to end, each feature where the first map that has it puts it.
double composed_chi2(const SubmapSet<2>& set) {
  Table<PoseIndex, Pose<2>> poses(set.poses.size());
  std::map<FeatureIndex, Point<2>> features;
  double chi2 = 0.0;
  for (const LocalMap<2>& map : set.graph.submaps) {
    const Pose<2>& base = poses[map.base];
    Eigen::VectorXd residual = Eigen::VectorXd::Zero(map.information.rows());
    for (std::size_t i = 0; i < map.poses.size(); ++i) {
      poses[map.poses[i]] = compose(base, map.pose_estimates[i]);
    }
    for (std::size_t i = 0; i < map.features.size(); ++i) {
      const auto known = features.emplace(map.features[i], transform(base, map.feature_estimates[i])).first;
      const auto row = static_cast<Eigen::Index>(3 * map.poses.size() + 2 * i);
      residual.segment<2>(row) = map.feature_estimates[i] - transform_into(base, known->second);
    }
    chi2 += residual.dot(map.information * residual);
  }
  return chi2;
}

TEST(LocalMapSetData, VictoriaParkIn200Maps) {
  const auto mat = read<2>(data_file("vicpark-200-local-maps"));
  EXPECT_EQ(mat.graph.submaps.size(), 200u);
  EXPECT_EQ(mat.features.size(), 299u);
  expect_equal(mat, read<2>(data_file("vicpark-200-local-maps/localmaps_txt.tar.gz")));
  EXPECT_NEAR(composed_chi2(mat), 13859095.8, 0.1);
}

TEST(LocalMapSetData, DlrIn200Maps) {
  const auto mat = read<2>(data_file("dlr-200-local-maps"));
  EXPECT_EQ(mat.features.size(), 549u);
  expect_equal(mat, read<2>(data_file("dlr-200-local-maps/localmaps_txt.tar.gz")));
}

TEST(LocalMapSetData, SimulationsAndSmallSets) {
  const auto sim = read<2>(data_file("sim-35188/localmaps_mat.tar.gz"));
  EXPECT_EQ(sim.graph.submaps.size(), 700u);
  EXPECT_EQ(sim.features.size(), 4202u);
  expect_equal(sim, read<2>(data_file("sim-35188/localmaps_txt.tar.gz")));
  EXPECT_EQ(read<2>(data_file("sim-535/local_maps")).features.size(), 28u);
  EXPECT_EQ(read<2>(data_file("small-local-maps-5-truth")).features.size(), 37u);
  EXPECT_EQ(read<2>(data_file("small-local-maps-64")).graph.submaps.size(), 64u);
}

TEST(LocalMapSetData, SimulationInSpace) {
  const auto mat = read<3>(data_file("sim3d-870-local-maps/localmaps_mat.tar.gz"));
  EXPECT_EQ(mat.graph.submaps.size(), 870u);
  EXPECT_EQ(mat.features.size(), 933u);
  expect_equal(mat, read<3>(data_file("sim3d-870-local-maps/localmaps_txt.tar.gz")));
}

TEST(LocalMapSetData, TheLastMapOfDlrIn3298MapsStandsStill) {
  const auto mat = read<2>(data_file("dlr/localmaps_3298_mat.tar.gz"));
  const auto text = read<2>(data_file("dlr/localmaps_3298_txt.tar.gz"));
  ASSERT_EQ(mat.graph.submaps.size(), 3298u);
  ASSERT_EQ(mat.poses.size(), 3298u);
  ASSERT_EQ(text.poses.size(), 3299u);
  for (std::size_t k = 0; k < 3297; ++k) expect_equal(mat.graph.submaps[k], text.graph.submaps[k]);
  const LocalMap<2>& last = mat.graph.submaps.back();
  EXPECT_EQ(last.base, PoseIndex(3297));
  EXPECT_TRUE(last.poses.empty());
  EXPECT_EQ(last.features, text.graph.submaps.back().features);
  const Eigen::MatrixXd W = text.graph.submaps.back().information.bottomRightCorner(16, 16);
  EXPECT_LT((last.information - W).norm(), 1e-9 * W.norm());
}

TEST(LocalMapSetData, VictoriaParkIn6898MapsIsTheCleanData) {
  const auto set = read<2>(data_file("vicpark-6898/localmaps_mat.tar.gz"));
  ASSERT_EQ(set.graph.submaps.size(), 6898u);
  const auto bytes = FileBytes::read(data_file("vicpark-6898/VicPark_clean_data.mat"));
  const Eigen::MatrixXd rows = read_mat(bytes->view(), "clean data", {"VicPark_clean_data"})->at("VicPark_clean_data");
  ASSERT_EQ(rows.rows(), 52288);

  std::vector<std::size_t> features_seen(set.graph.submaps.size(), 0);
  for (const auto& row : rows.rowwise()) {
    const auto k = static_cast<std::size_t>(row[1]);
    const LocalMap<2>& map = set.graph.submaps[k];
    Eigen::Index at = 0;
    Eigen::MatrixXd P;
    if (row[0] == 1.0) {
      P = (Matrix<3>() << row[6], row[7], row[8], row[7], row[9], row[10], row[8], row[10], row[11]).finished();
      const Vector<3> motion(row[3], row[4], row[5]);
      ASSERT_EQ(local(Pose<2>{}, map.pose_estimates[0]), motion);
    } else {
      P = (Matrix<2>() << row[5], row[6], row[6], row[7]).finished();
      const std::size_t i = features_seen[k]++;
      ASSERT_EQ(set.features[map.features[i]].key, static_cast<std::uint64_t>(row[2]));
      ASSERT_EQ(map.feature_estimates[i], Point<2>(row[3], row[4]));
      at = static_cast<Eigen::Index>(3 + 2 * i);
    }
    const Eigen::Index n = P.rows();
    // Two steps of the clean data have variances of the motion that are larger than those of the maps by 1e-6.
    if (row[0] == 1.0 && (k == 3717 || k == 6778)) P.diagonal().array() -= 1e-6;
    ASSERT_LT((map.information.block(at, at, n, n) * P - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-9) << row;
  }
  for (std::size_t k = 0; k < set.graph.submaps.size(); ++k) EXPECT_EQ(features_seen[k], set.graph.submaps[k].features.size());
}

}  // namespace
}  // namespace mapjoin
