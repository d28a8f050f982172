// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

class MapMat : public ::testing::Test {
 protected:
  MatVariables written(const auto& map) {
    const auto file = folder.path() / "map.mat";
    EXPECT_TRUE(write_mat_map(map, file));
    return read_mat(content_of(file), file, {"poses", "features", "stamps", "pose_covariances", "feature_covariances"}).value();
  }
  TemporaryFolder folder;
};

TEST_F(MapMat, HasRowsOfIdsAndValues) {
  GlobalMap<2> map;
  map.pose_ids = PoseIds({{0, 4}, {1, 9}});
  map.poses = {Pose<2>{Point<2>(1.0, 2.0), Rotation<2>(0.5)}, Pose<2>{Point<2>(3.0, 4.0), Rotation<2>(-0.5)}};
  map.feature_ids = FeatureIds({{17}});
  map.features = {Point<2>(7.0, 8.0)};
  const auto plain = written(map);
  EXPECT_EQ(plain.at("poses"), (Eigen::MatrixXd(2, 5) << 0, 4, 1, 2, 0.5, 1, 9, 3, 4, -0.5).finished());
  EXPECT_EQ(plain.at("features"), (Eigen::MatrixXd(1, 3) << 17, 7, 8).finished());
  EXPECT_EQ(plain.size(), 2U) << "and no more than the map has";

  map.stamps_ns = {1'500'000'000, 2'000'000'000};
  map.pose_covariances = {PoseMatrix<2>::Zero(), PoseMatrix<2>::Identity()};
  map.feature_covariances = {(PointMatrix<2>() << 1, 2, 2, 5).finished()};
  const auto whole = written(map);
  EXPECT_EQ(whole.at("stamps"), Eigen::Vector2d(1.5, 2.0));
  EXPECT_EQ(whole.at("pose_covariances").row(1), (Eigen::Matrix<double, 1, 6>() << 1, 0, 0, 1, 0, 1).finished());
  EXPECT_EQ(whole.at("feature_covariances"), Eigen::RowVector3d(1, 2, 5));
}

TEST_F(MapMat, HasQuaternionsInSpace) {
  GlobalMap<3> map;
  map.pose_ids = PoseIds({{0, 4}});
  map.poses = {Pose<3>{Point<3>(1.0, 2.0, 3.0), Rotation<3>()}};
  EXPECT_EQ(written(map).at("poses"), (Eigen::MatrixXd(1, 9) << 0, 4, 1, 2, 3, 0, 0, 0, 1).finished());
}

TEST_F(MapMat, RefusesIdsThatADoubleDoesNotHold) {
  GlobalMap<2> map;
  map.pose_ids = PoseIds({{0, (std::uint64_t{'a'} << 56) + 3}});
  map.poses.resize(1);
  const auto refused = write_mat_map(map, folder.path() / "map.mat");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("pose a3 has an id of 2^53 or more, which a MAT file cannot say"));
}

}  // namespace
}  // namespace mapjoin::testing
