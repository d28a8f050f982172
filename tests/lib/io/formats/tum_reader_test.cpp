// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/formats/trajectory.hpp>
#include <tests/support/random.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

Expected<std::vector<StampedPose>> trajectory_of(const std::string& text) {
  return read_tum(TextScanner("trajectory.tum", text));
}

TEST(TumReader, ReadsWhatIsWritten) {
  testing::Random random;
  GlobalMap<3> map;
  for (std::uint64_t k = 0; k < 5; ++k) {
    map.pose_ids.push_back({0, k});
    map.poses.push_back(random.pose<3>());
    map.stamps_ns.push_back(static_cast<std::int64_t>(k) * 250'000'000);
  }
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "trajectory.tum";
  ASSERT_TRUE(write_tum(map, path));
  const auto poses = trajectory_of(testing::content_of(path));
  ASSERT_TRUE(poses) << poses.error().message;
  ASSERT_EQ(poses->size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ((*poses)[k].time, 0.25 * static_cast<double>(k));
    EXPECT_LT(local((*poses)[k].pose, map.poses[PoseIndex(k)]).norm(), 1e-15);
  }
}

TEST(TumReader, BringsQuaternionsOfAnySizeToUnitLength) {
  const auto poses = trajectory_of("0 1 2 3 0 0 1e308 1e308\n1 1 2 3 0 4.9e-324 0 0\n");
  ASSERT_TRUE(poses) << poses.error().message;
  EXPECT_NEAR((*poses)[0].pose.rotation.quaternion().w(), std::sqrt(0.5), 1e-15);
  EXPECT_EQ((*poses)[1].pose.rotation.quaternion().y(), 1.0);
}

TEST(TumReader, NamesThePlaceOfWhatIsWrong) {
  const auto short_line = trajectory_of("# time x y z qx qy qz qw\n0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0\n");
  ASSERT_FALSE(short_line);
  EXPECT_TRUE(short_line.error().message.starts_with("trajectory.tum:3:")) << short_line.error().message;
  const auto zero = trajectory_of("0 1 2 3 0 0 0 0\n");
  ASSERT_FALSE(zero);
  EXPECT_NE(zero.error().message.find("quaternion is zero"), std::string::npos);
}

TEST(TumReader, TakesATimeTwiceWithTheSamePoseOnly) {
  const std::string lines = "2 5 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n";
  EXPECT_TRUE(trajectory_of(lines));
  const auto other = trajectory_of(lines + "1 1 2 4 0 0 0 1\n");
  ASSERT_FALSE(other);
  EXPECT_TRUE(other.error().message.starts_with("trajectory.tum:4:")) << other.error().message;
  EXPECT_TRUE(other.error().message.ends_with(
      "a line before has another pose at the same time; keep one, or give a table of poses, which names sessions"));
}

}  // namespace
}  // namespace mapjoin
