// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <apps/picture/plotted_map.hpp>
#include <vector>

namespace mapjoin::apps {
namespace {

/// Of so many poses on a line, each with a standard deviation of two metres.
std::vector<Ellipse> pose_ellipses(int poses) {
  PlottedMap<2> plotted;
  for (int k = 0; k < poses; ++k) {
    plotted.map.poses.push_back({{1.0 * k, 0.0}, Rotation<2>(0.0)});
    plotted.map.pose_covariances.push_back(4.0 * PoseMatrix<2>::Identity());
  }
  plotted.sessions = {{0, PoseIndex(poses)}};
  const std::vector<Layer> layers = map_layers<2>({plotted}, nullptr);
  const auto found = std::ranges::find(layers, "3σ of poses", &Layer::name);
  return found == layers.end() ? std::vector<Ellipse>() : found->ellipses;
}

TEST(MapLayers, HaveTheEllipsesOfAboutFiftyPosesWhereNoLocalMapsAreKnown) {
  EXPECT_EQ(pose_ellipses(30).size(), 30U);
  for (const int poses : {500, 5000}) {
    EXPECT_GE(pose_ellipses(poses).size(), 40U);
    EXPECT_LE(pose_ellipses(poses).size(), 50U);
  }
}

TEST(MapLayers, HaveEllipsesOfThreeStandardDeviations) {
  EXPECT_NEAR((pose_ellipses(1).at(0).half_axes - Point<2>(6.0, 6.0)).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace mapjoin::apps
