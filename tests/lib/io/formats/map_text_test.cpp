// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <mapjoin/gps/geographic_frame.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <tests/support/temporary_folder.hpp>
#include <vector>

namespace mapjoin {
namespace {

using ::testing::DoubleNear;
using ::testing::Pointwise;
using ::testing::ThrowsMessage;

/// The coordinates of a MultiLineString.
using Lines = std::vector<std::vector<std::vector<double>>>;

class MapText : public ::testing::Test {
 protected:
  template <int Dim>
  using Write = Expected<void> (*)(const GlobalMap<Dim>&, const std::filesystem::path&);

  template <int Dim>
  std::string written(Write<Dim> write, const GlobalMap<Dim>& map) {
    const auto done = write(map, path);
    return done ? testing::content_of(path) : done.error().message;
  }
  /// Writes the tables of poses and of features, and returns their contents.
  template <int Dim>
  std::pair<std::string, std::string> tables(const GlobalMap<Dim>& map) {
    const auto done = write_csv(map, path, beside);
    EXPECT_TRUE(done) << done.error().message;
    return {testing::content_of(path), testing::content_of(beside)};
  }

  /// Two poses, one after a whole turn, and a feature.
  static GlobalMap<2> plane() {
    GlobalMap<2> map;
    map.pose_ids = {{0, 4}, {0, 7}};
    map.poses = {{{0.1, -2.0}, Rotation<2>(0.0)}, {{1e-7, 3.0}, Rotation<2>(2.0 * std::numbers::pi)}};
    map.feature_ids = {{9}};
    map.features = {{5.0, 1.0 / 3.0}};
    return map;
  }
  static GlobalMap<3> space() {
    GlobalMap<3> map;
    map.pose_ids = {{0, 4}, {2, 4}};
    map.poses = {{{1, 2, 3}, Rotation<3>()}, {{4, 5, 6}, Rotation<3>(Eigen::Quaterniond(0.8, 0.6, 0.0, 0.0))}};
    map.feature_ids = {{9}};
    map.features = {{7, 8, 9}};
    map.stamps_ns = {1'500'000'001, -20};
    return map;
  }

  testing::TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "out";
  std::filesystem::path beside = folder.path() / "beside";
};

TEST_F(MapText, TumHasIndicesWhereThereAreNoStampsAndSaysSo) {
  EXPECT_EQ(written<2>(write_tum, plane()),
            "# index x y z qx qy qz qw (the poses have no time stamps)\n"
            "0 0.1 -2 0 0 0 0 1\n"
            "1 1e-07 3 0 0 0 0 1\n");
}

TEST_F(MapText, TablesHaveTheUpperTrianglesOfCovariances) {
  auto map = plane();
  const Matrix<3> of_pose = (Matrix<3>() << 1, 2, 3, 2, 4, 5, 3, 5, 6).finished();
  map.pose_covariances = {Matrix<3>::Zero(), of_pose};
  map.feature_covariances = {(Matrix<2>() << 7, 8, 8, 9).finished()};
  const auto [poses, features] = tables<2>(map);
  EXPECT_EQ(poses,
            "pose,x,y,phi,cov_x_x,cov_x_y,cov_x_phi,cov_y_y,cov_y_phi,cov_phi_phi\n"
            "4,0.1,-2,0,0,0,0,0,0,0\n"
            "7,1e-07,3,6.283185307179586,1,2,3,4,5,6\n");
  EXPECT_EQ(features,
            "feature,x,y,cov_x_x,cov_x_y,cov_y_y\n"
            "9,5,0.3333333333333333,7,8,9\n");
}

TEST_F(MapText, TumTurnsAHeadingAboutZ) {
  auto map = plane();
  map.poses[0].rotation = Rotation<2>(-2.5);
  std::istringstream words(written<2>(write_tum, map));
  words.ignore(1000, '\n');
  Vector<8> line;
  for (double& number : line) words >> number;
  const Eigen::Quaterniond q(Vector<4>(line.tail<4>()));
  EXPECT_TRUE((q * Vector<3>::UnitX()).isApprox(Vector<3>(std::cos(-2.5), std::sin(-2.5), 0.0), 1e-14));
}

TEST_F(MapText, TumHasSecondsToTheNanosecond) {
  EXPECT_EQ(written<3>(write_tum, space()),
            "# time[s] x y z qx qy qz qw\n"
            "1.500000001 1 2 3 0 0 0 1\n"
            "-0.000000020 4 5 6 0.6 0 0 0.8\n");
}

TEST_F(MapText, CsvOfPosesKeepsTheirNamesAndHeadings) {
  EXPECT_EQ(tables(plane()).first, "pose,x,y,phi\n4,0.1,-2,0\n7,1e-07,3,6.283185307179586\n");
}

TEST_F(MapText, CsvOfPosesHasSessionsAndStampsWhereTheMapHas) {
  EXPECT_EQ(tables(space()).first,
            "session,pose,x,y,z,qx,qy,qz,qw,stamp_ns\n"
            "0,4,1,2,3,0,0,0,1,1500000001\n"
            "2,4,4,5,6,0.6,0,0,0.8,-20\n");
}

TEST_F(MapText, CsvOfFeatures) {
  EXPECT_EQ(tables(plane()).second, "feature,x,y\n9,5,0.3333333333333333\n");
  EXPECT_EQ(tables(space()).second, "feature,x,y,z\n9,7,8,9\n");
}

TEST_F(MapText, CsvOfFeaturesIsWrittenAlsoWhereThereAreNone) {
  auto map = plane();
  map.features.clear();
  map.feature_ids.clear();
  EXPECT_EQ(tables(map).second, "feature,x,y\n");
}

TEST_F(MapText, GeoJsonHasALineOfEachSessionAndAPointOfASinglePose) {
  GlobalMap<2> map;
  map.pose_ids = {{0, 0}, {0, 1}, {1, 0}};
  map.poses.resize(3);
  ASSERT_TRUE(write_geojson(map, GeographicFrame({50.0, 8.0, 0.0}), path));
  const auto features = nlohmann::json::parse(testing::content_of(path))["features"];
  ASSERT_EQ(features.size(), 2U);
  EXPECT_EQ(features[0]["geometry"]["type"], "LineString");
  EXPECT_EQ(features[0]["geometry"]["coordinates"].size(), 2U);
  EXPECT_EQ(features[1]["geometry"]["type"], "Point");
  EXPECT_EQ(features[1]["geometry"]["coordinates"].size(), 2U) << "longitude and latitude";
  EXPECT_EQ(features[1]["properties"]["session"], 1);
}

TEST_F(MapText, GeoJsonCutsATrajectoryAtTheAntimeridian) {
  // A way in Fiji, over the antimeridian to the east and back.
  const GeographicFrame frame({-17.0, 180.0, 0.0});
  GlobalMap<3> map;
  map.pose_ids = {{0, 0}, {0, 1}, {0, 2}};
  for (const GeographicPoint& place :
       {GeographicPoint{-17.0, 179.9, 10.0}, {-17.2, -179.7, 50.0}, GeographicPoint{-17.2, 179.7, 0.0}}) {
    map.poses.push_back({frame.to_local(place), {}});
  }
  ASSERT_TRUE(write_geojson(map, frame, path));
  const auto geometry = nlohmann::json::parse(testing::content_of(path))["features"][0]["geometry"];
  EXPECT_EQ(geometry["type"], "MultiLineString");
  const Lines expected = {{{179.9, -17.0, 10.0}, {180.0, -17.05, 20.0}},
                          {{-180.0, -17.05, 20.0}, {-179.7, -17.2, 50.0}, {-180.0, -17.2, 25.0}},
                          {{180.0, -17.2, 25.0}, {179.7, -17.2, 0.0}}};
  const auto lines = geometry["coordinates"].get<Lines>();
  ASSERT_EQ(lines.size(), expected.size());
  for (std::size_t k = 0; k < lines.size(); ++k) {
    ASSERT_EQ(lines[k].size(), expected[k].size()) << "line " << k;
    for (std::size_t i = 0; i < lines[k].size(); ++i) {
      EXPECT_THAT(lines[k][i], Pointwise(DoubleNear(1e-6), expected[k][i])) << "line " << k << ", position " << i;
    }
  }
}

TEST_F(MapText, GeoJsonFollowsATrajectoryThatRestsOnTheAntimeridian) {
  // Poses on the antimeridian may be written at 180 or at -180 degrees, but each line stays on one side.
  GlobalMap<2> map;
  for (const double east : {-9.0, 0.0, 0.0, 9.0, 0.0, -9.0, 9.0}) {
    map.pose_ids.push_back({0, map.pose_ids.size()});
    map.poses.push_back({Point<2>(east, 0.0), {}});
  }
  for (const double longitude : {-180.0, 180.0}) {
    ASSERT_TRUE(write_geojson(map, GeographicFrame({0.0, longitude, 0.0}), path));
    const auto geometry = nlohmann::json::parse(testing::content_of(path))["features"][0]["geometry"];
    for (const auto& line : geometry["coordinates"].get<Lines>()) {
      ASSERT_GE(line.size(), 2U);
      for (const auto& place : line) EXPECT_NEAR(place[0], std::copysign(180.0, line[0][0]), 1e-3);
    }
  }
}

TEST_F(MapText, SaysWhenItCannotWrite) {
  path = folder.path() / "no" / "out";
  EXPECT_EQ(written<2>(write_tum, plane()), path.string() + ": No such file or directory");
}

TEST_F(MapText, AMapThatIsNotWholeIsRefused) {
  const auto expect_refused = [&](const GlobalMap<3>& map, const std::string& why) {
    EXPECT_THAT([&] { written<3>(write_tum, map); }, ThrowsMessage<std::invalid_argument>(why));
    EXPECT_THROW(written<3>(write_kitti, map), std::invalid_argument);
    EXPECT_THROW(written<3>(write_pose_csv, map), std::invalid_argument);
    EXPECT_THROW(tables(map), std::invalid_argument);
    EXPECT_THROW(write_geojson(map, GeographicFrame({50.0, 8.0, 0.0}), path), std::invalid_argument);
    EXPECT_THROW(write_geographic_csv(map, GeographicFrame({50.0, 8.0, 0.0}), path), std::invalid_argument);
    EXPECT_THROW(write_mat_map(map, path), std::invalid_argument);
    EXPECT_THROW(write_g2o<3>(map, nullptr, path), std::invalid_argument);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  };
  const auto with = [](const auto& change) {
    GlobalMap<3> map = space();
    change(map);
    return map;
  };
  expect_refused(with([](auto& map) { map.pose_ids.pop_back(); }), "a map has 1 names of poses, but 2 of these");
  expect_refused(with([](auto& map) { map.feature_ids.clear(); }), "a map has 0 names of features, but 1 of these");
  expect_refused(with([](auto& map) { map.stamps_ns.pop_back(); }), "a map has 1 stamps of poses, but 2 of these");
  expect_refused(with([](auto& map) { map.pose_covariances.resize(1); }), "a map has 1 covariances of poses, but 2 of these");
  expect_refused(with([](auto& map) { map.feature_covariances.resize(2); }),
                 "a map has 2 covariances of features, but 1 of these");
  expect_refused(with([](auto& map) { map.gauge = {2}; }), "a map is anchored at a pose that is not in it");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string not_finite = "a map has a value that is not finite, or no rotation";
  expect_refused(with([=](auto& map) { map.poses[0].translation[1] = nan; }), not_finite);
  expect_refused(with([=](auto& map) { map.features[0][2] = nan; }), not_finite);
  expect_refused(with([=](auto& map) { map.pose_covariances.assign(2, PoseMatrix<3>::Constant(nan)); }), not_finite);
  expect_refused(with([=](auto& map) { map.feature_covariances.assign(1, PointMatrix<3>::Constant(nan)); }), not_finite);
}

TEST_F(MapText, TwoTablesInOneFileAreRefused) {
  std::filesystem::create_symlink(path.filename(), beside);
  for (const std::filesystem::path& same : {path, path.parent_path() / "." / path.filename(), beside}) {
    const auto done = write_csv(plane(), path, same);
    ASSERT_FALSE(done) << same;
    EXPECT_EQ(done.error().kind, ErrorKind::kUsage);
    EXPECT_EQ(done.error().message,
              path.string() + ": is named for the poses and for the features; each takes a file of its own");
    EXPECT_FALSE(std::filesystem::exists(path));
  }
  EXPECT_TRUE(write_csv(plane(), "/dev/null", "/dev/null")) << "which keeps neither";
}

TEST_F(MapText, NeitherTableAppearsWhereOneCannot) {
  for (const std::filesystem::path& missing : {folder.path() / "no" / "out", std::filesystem::path("/dev/full")}) {
    EXPECT_FALSE(write_csv(plane(), path, missing));
    EXPECT_FALSE(write_csv(plane(), missing, path));
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
}

}  // namespace
}  // namespace mapjoin
