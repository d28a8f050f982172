// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/run_folder.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

/// A run over two sessions, the first of which does not drive in the order of its ids, and a feature with the key of a pose: a
/// g2o file has other names for them.
class RunFolder : public ::testing::Test {
 protected:
  RunFolder() {
    LogBuilder<2> builder("two.g2o");
    const Matrix<3> W = Matrix<3>::Identity();
    builder.add_pose_edge({0, 9}, {0, 4}, {Point<2>(1.0, 0.0), {}}, W);
    builder.add_pose_edge({1, 10}, {1, 11}, {Point<2>(1.0, 0.0), {}}, W);
    builder.add_pose_edge({0, 4}, {1, 10}, {Point<2>(1.0, 0.0), {}}, W);
    builder.add_observation({1, 11}, {4}, Point<2>(0.0, 1.0), Matrix<2>::Identity());
    log_ = std::move(builder).finish(PoseIds({{0, 9}, {0, 4}, {1, 10}, {1, 11}})).value();
    map_.pose_ids = log_.poses;
    for (double x = 0.0; x < 4.0; ++x) map_.poses.push_back({Point<2>(x, 0.0), {}});
    map_.feature_ids = log_.features;
    map_.features = {Point<2>(3.0, 1.0)};
    map_.stamps_ns = log_.stamps_ns = {50, 60, 10, 20};
    write();
  }
  void write() const {
    ASSERT_TRUE(write_csv(map_, folder_.path() / "poses.csv", folder_.path() / "features.csv"));
    ASSERT_TRUE(write_g2o(map_, &log_, folder_.path() / kMapOfRun));
  }
  Log<2> read() const { return std::get<Log<2>>(open_log(folder_.path()).value()); }

  testing::TemporaryFolder folder_;
  Log<2> log_;
  GlobalMap<2> map_;
};

TEST_F(RunFolder, IsALogUnderTheNamesOfTheLogThatItWasMadeOf) {
  ASSERT_NE(std::get<Log<2>>(open_log(folder_.path() / kMapOfRun).value()).features, log_.features);
  const Log<2> read = this->read();
  EXPECT_EQ(read.poses, log_.poses);
  EXPECT_EQ(read.features, log_.features);
  EXPECT_EQ(read.stamps_ns, log_.stamps_ns);
  EXPECT_EQ(read.sessions.size(), 2U);
  EXPECT_EQ(read.odometry().size(), 2U);
  EXPECT_EQ(read.closures().size(), 1U) << "between sessions";
  EXPECT_EQ(read.closures()[0].base, PoseIndex(1));
  EXPECT_EQ(read.initial.poses[PoseIndex(3)].translation, Point<2>(3.0, 0.0));
  EXPECT_EQ(read.initial.features[FeatureIndex(0)], Point<2>(3.0, 1.0));
}

TEST_F(RunFolder, WithoutItsTablesHasTheNamesOfItsMap) {
  std::filesystem::remove(folder_.path() / "features.csv");
  EXPECT_THAT(testing::error_of(open_log(folder_.path())), HasSubstr("features.csv: is missing beside poses.csv"));
  std::filesystem::remove(folder_.path() / "poses.csv");
  EXPECT_EQ(read().poses, std::get<Log<2>>(open_log(folder_.path() / kMapOfRun).value()).poses);
}

TEST_F(RunFolder, RefusesTablesOfAnotherMap) {
  map_.poses[PoseIndex(2)].translation.x() += 0.5;
  ASSERT_TRUE(write_csv(map_, folder_.path() / "poses.csv", folder_.path() / "features.csv"));
  EXPECT_THAT(testing::error_of(open_log(folder_.path())), HasSubstr("poses.csv: is not of the map beside it; remove it"));
}

TEST_F(RunFolder, ReadsItsTableOfPosesAsAnyOther) {
  const auto poses = folder_.path() / "poses.csv";
  folder_.file("poses.csv", "pose,session,stamp_ns,x,y,phi\n9,0,50,0,0,0\n4,0,60,1,0,0\n10,1,10,2,0,0\n11,1,20,3,0,0\n");
  EXPECT_EQ(read().poses, log_.poses) << "whatever the order of its columns";
  EXPECT_EQ(read().stamps_ns, log_.stamps_ns);
  folder_.file("poses.csv", "pose,x,y\n9,0,0\n");
  EXPECT_THAT(testing::error_of(open_log(folder_.path())),
              HasSubstr(poses.string() + ":1: does not name the columns pose and, side by side, x,y,phi"));
}

TEST_F(RunFolder, WithLocalMapsIsAFolderOfThese) {
  EXPECT_TRUE(is_run_folder(folder_.path()));
  EXPECT_FALSE(may_hold_maps(folder_.path()));
  folder_.file("localmap_1.txt", "0\n");
  EXPECT_FALSE(is_run_folder(folder_.path()));
  EXPECT_TRUE(may_hold_maps(folder_.path()));
}

TEST_F(RunFolder, NamesThatAMapHasAlreadyStay) {
  const Log<2> read = this->read();
  const Log<2> again = with_names(map_, read, "told.json").value();
  EXPECT_EQ(again.poses, read.poses);
  EXPECT_EQ(again.features, read.features);
  map_.feature_ids = {{5}};
  EXPECT_THAT(testing::error_of(with_names(map_, read, "told.json")), HasSubstr("told.json: is not of the map beside it"));
}

}  // namespace
}  // namespace mapjoin
