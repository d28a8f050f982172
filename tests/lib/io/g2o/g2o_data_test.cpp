// SPDX-License-Identifier: BSD-3-Clause
// Public g2o files: counts and chi2 as their README gives them, and the fixed point of writing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <optional>
#include <set>
#include <string>
#include <tests/support/data.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

struct Graph {
  std::string file;
  int dimension;
  std::size_t poses, features, edges, observations;
  std::optional<double> chi2;        ///< chi2 of g2o's error, at the stored vertices.
  double relative_precision = 1e-6;  ///< Precision of chi2 in the README.
};

std::ostream& operator<<(std::ostream& out, const Graph& graph) {
  return out << graph.file;
}

/// The error of g2o, Z⁻¹ X_b⁻¹ X_t; in space with the vector part of its quaternion.
PoseVector<2> g2o_error(const Pose<2>& Z, const Pose<2>& b, const Pose<2>& t) {
  const Pose<2> E = compose(inverse(Z), compose(inverse(b), t));
  return {E.translation.x(), E.translation.y(), wrap_angle(E.rotation.angle())};
}
PoseVector<3> g2o_error(const Pose<3>& Z, const Pose<3>& b, const Pose<3>& t) {
  const Pose<3> E = compose(inverse(Z), compose(inverse(b), t));
  const auto q = E.rotation.quaternion();
  return (PoseVector<3>() << E.translation, q.w() < 0.0 ? Vector<3>(-q.vec()) : Vector<3>(q.vec())).finished();
}

/// The chi2 of g2o's error at the values of the file; the information matrices must have been read as they are.
template <int Dim>
double g2o_chi2(const Log<Dim>& log) {
  const auto pose = [&](PoseIndex i) -> const Pose<Dim>& { return log.initial.poses.at(i.position()); };
  double chi2 = 0.0;
  for (const auto& edge : log.edges()) {
    const auto e = g2o_error(edge.measured, pose(edge.base), pose(edge.target));
    chi2 += e.dot(edge.information * e);
  }
  for (const auto& o : log.observations()) {
    const Point<Dim> feature = log.initial.features.at(o.target.position());
    const Point<Dim> e = pose(o.base).rotation.matrix().transpose() * (feature - pose(o.base).translation) - o.measured;
    chi2 += e.dot(o.information * e);
  }
  return chi2;
}

Expected<AnyLog> read(const std::filesystem::path& path, const ReadOptions& options) {
  const auto bytes = FileBytes::read(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return read_g2o(TextScanner(path.filename(), bytes->view()), options);
}

class G2oData : public ::testing::TestWithParam<Graph> {
 protected:
  AnyLog read_graph() {
    auto log =
        read(testing::data_file(GetParam().file), {.repair_information = GetParam().file.find("cubicle") != std::string::npos});
    if (!log) throw std::runtime_error(log.error().message);
    return *std::move(log);
  }
};

TEST_P(G2oData, HasTheCountsAndTheChi2OfItsReadme) {
  std::visit(
      [&]<int Dim>(const Log<Dim>& log) {
        EXPECT_EQ(Dim, GetParam().dimension);
        EXPECT_EQ(log.poses.size(), GetParam().poses);
        EXPECT_EQ(log.features.size(), GetParam().features);
        EXPECT_EQ(log.edges().size(), GetParam().edges);
        EXPECT_EQ(log.observations().size(), GetParam().observations);
        if (const auto chi2 = GetParam().chi2) {
          EXPECT_NEAR(g2o_chi2(log), *chi2, GetParam().relative_precision * *chi2);
        }
      },
      read_graph());
}

TEST_P(G2oData, IsAFixedPointOfWritingAfterOnePass) {
  const testing::TemporaryFolder folder;
  const auto once = folder.path() / "once.g2o";
  const auto twice = folder.path() / "twice.g2o";
  ASSERT_TRUE(std::visit([&](const auto& log) { return write_g2o(log, once); }, read_graph()));
  const auto again = read(once, {});
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_TRUE(std::visit([&](const auto& log) { return write_g2o(log, twice); }, *again));
  EXPECT_TRUE(testing::content_of(once) == testing::content_of(twice));
}

INSTANTIATE_TEST_SUITE_P(
    Public, G2oData,
    ::testing::Values(Graph{"vicpark-6898/vicpark6898.g2o.gz", 2, 6899, 299, 6898, 45390, 1.2144075064e10, 1e-10},
                      Graph{"dlr/dlr_corrected.g2o.gz", 2, 3298, 549, 3297, 14184, 3.650023e8},
                      Graph{"dlr/dlr.g2o.gz", 2, 3297, 576, 3296, 14309, 369655329.2, 1e-9},
                      Graph{"pose-graphs-2d/CSAIL.g2o.gz", 2, 1045, 0, 1172, 0, {}},
                      Graph{"pose-graphs-2d/MIT.g2o.gz", 2, 808, 0, 827, 0, 4.414182e9},
                      Graph{"pose-graphs-2d/ais2klinik.g2o.gz", 2, 15115, 0, 16727, 0, 1297393.9, 1e-7},
                      Graph{"pose-graphs-2d/city10000.g2o.gz", 2, 10000, 0, 20687, 0, 6.541627e8},
                      Graph{"pose-graphs-2d/intel.g2o.gz", 2, 1728, 0, 2512, 0, 551.7357, 1e-7},
                      Graph{"pose-graphs-2d/kitti_00.g2o.gz", 2, 4541, 0, 4677, 0, {}},
                      Graph{"pose-graphs-2d/kitti_02.g2o.gz", 2, 4661, 0, 4703, 0, {}},
                      Graph{"pose-graphs-2d/kitti_05.g2o.gz", 2, 2761, 0, 2826, 0, {}},
                      Graph{"pose-graphs-2d/manhattan.g2o.gz", 2, 3500, 0, 5453, 0, {}},
                      Graph{"pose-graphs-2d/manhattanOlson3500.g2o.gz", 2, 3500, 0, 5598, 0, 69142.94, 1e-7},
                      Graph{"pose-graphs-3d/cubicle.g2o.gz", 3, 5750, 0, 16869, 0, 9665717, 1e-7},
                      Graph{"pose-graphs-3d/parking-garage.g2o.gz", 3, 1661, 0, 6275, 0, 16720.018, 1e-7},
                      Graph{"pose-graphs-3d/smallGrid3D.g2o.gz", 3, 125, 0, 297, 0, 115958.0, 1e-6},
                      Graph{"pose-graphs-3d/tinyGrid3D.g2o.gz", 3, 9, 0, 11, 0, 213.064, 1e-5},
                      Graph{"pose-graphs-3d/sphere2500.g2o.gz", 3, 2500, 0, 4949, 0, 2547810.9, 1e-7},
                      Graph{"pose-graphs-3d/sphere_bignoise_vertex3.g2o.gz", 3, 2200, 0, 8647, 0, 1.766312e8},
                      Graph{"pose-graphs-3d/torus3D.g2o.gz", 3, 5000, 0, 9048, 0, 2946826.5, 1e-7},
                      Graph{"g2o-3d-landmark-fixtures/edge_se3_trackxyz_example.g2o", 3, 1, 1, 0, 1, {}},
                      Graph{"g2o-3d-landmark-fixtures/known_landmark_localization_3.g2o", 3, 3, 4, 2, 12, {}}));

TEST(G2oDataQuirks, CubicleIsOneDriveThoughItsIdsAreSwapped) {
  const auto log = read(testing::data_file("pose-graphs-3d/cubicle.g2o.gz"), {.repair_information = true});
  ASSERT_TRUE(log);
  EXPECT_EQ(std::get<Log<3>>(*log).sessions.size(), 1u);
}

TEST(G2oDataQuirks, CubicleHas5021IndefiniteInformationMatrices) {
  const auto path = testing::data_file("pose-graphs-3d/cubicle.g2o.gz");
  const auto refused = read(path, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(
      refused.error().message,
      ::testing::HasSubstr("cubicle.g2o.gz:5753:1: the information matrix of the edge from pose 1 to pose 2 is indefinite"));
  const auto log = std::get<Log<3>>(read(path, {.repair_information = true}).value());
  EXPECT_EQ(log.conventions.repairs.indefinite, 5021);

  std::set<std::pair<PoseIndex, PoseIndex>> directed;
  std::set<std::pair<PoseIndex, PoseIndex>> undirected;
  for (const auto& edge : log.edges()) {
    directed.emplace(edge.base, edge.target);
    undirected.insert(std::minmax(edge.base, edge.target));
  }
  EXPECT_EQ(16869u - directed.size(), 4296u);
  EXPECT_EQ(log.repeated_edges, static_cast<std::int64_t>(16869 - undirected.size()));
}

TEST(G2oDataQuirks, Ais2klinikMissesTheOdometryOfOnePairOfPoses) {
  const auto log = std::get<Log<2>>(read(testing::data_file("pose-graphs-2d/ais2klinik.g2o.gz"), {}).value());
  EXPECT_EQ(log.sessions.size(), 2u);
}

TEST(G2oDataQuirks, ManhattanOlsonRepeats145Edges) {
  const auto log = std::get<Log<2>>(read(testing::data_file("pose-graphs-2d/manhattanOlson3500.g2o.gz"), {}).value());
  EXPECT_EQ(log.repeated_edges, 145);
}

}  // namespace
}  // namespace mapjoin
