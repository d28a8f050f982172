// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <apps/picture/plotted_map.hpp>
#include <string>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <vector>

namespace mapjoin::apps {
namespace {

using ::testing::ElementsAre;

/// A map of `poses` poses a metre apart on a line, each coordinate with this standard deviation; without covariances if it is
/// 0.
PlottedMap<2> line_of(int poses, double deviation = 0.0) {
  PlottedMap<2> plotted;
  for (int k = 0; k < poses; ++k) {
    plotted.map.pose_ids.push_back({0, 10 + static_cast<std::uint64_t>(k)});
    plotted.map.poses.push_back({{1.0 * k, 0.0}, Rotation<2>(0.0)});
    if (deviation > 0.0) plotted.map.pose_covariances.push_back(deviation * deviation * PoseMatrix<2>::Identity());
  }
  plotted.sessions = {{0, PoseIndex(poses)}};
  return plotted;
}

std::vector<std::string> names_of(const std::vector<Layer>& layers) {
  std::vector<std::string> names;
  for (const Layer& layer : layers) names.push_back(layer.name);
  return names;
}

std::vector<Ellipse> pose_ellipses(int poses) {
  const std::vector<Layer> layers = map_layers<2>({line_of(poses, 2.0)}, nullptr);
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
  EXPECT_NEAR((pose_ellipses(30).at(0).half_axes - Point<2>(6.0, 6.0)).norm(), 0.0, 1e-12);
}

TEST(MapLayers, HaveEllipsesNoLargerThanTheMapAndSaySo) {
  PlottedMap<2> plotted = line_of(11, 1.6);  // 10 m long, each ellipse 9.6 m
  EXPECT_EQ(ellipse_cap(plotted.map).in_words(), "");
  plotted.map.pose_covariances[4](0, 0) = 4.0;
  plotted.map.features.push_back({0.0, 0.0});
  plotted.map.feature_covariances.push_back(100.0 * Matrix<2>::Identity());
  const std::vector<Layer> layers = map_layers<2>({plotted}, nullptr);
  const auto poses = std::ranges::find(layers, "3σ of poses (capped at the map's size)", &Layer::name);
  ASSERT_NE(poses, layers.end());
  EXPECT_NEAR((poses->ellipses[4].half_axes - Point<2>(5.0, 4.8)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((poses->ellipses[5].half_axes - Point<2>(4.8, 4.8)).norm(), 0.0, 1e-9);
  EXPECT_EQ(ellipse_cap(plotted.map).in_words(),
            "the 3σ ellipses of 1 pose and 1 feature are larger than the map, and are capped at its size");
}

TEST(MapLayers, HaveTheWorstLinksOnTopAndRejectedOnesApartBelow) {
  PlottedMap<2> plotted = line_of(9);
  const auto add = [&](std::optional<double> residual, bool is_rejected) {
    plotted.links.push_back({PoseIndex(plotted.links.size()), PoseIndex(8), is_rejected, residual});
  };
  add(99.0, false);
  add(99.0, true);
  add(5.0, false);
  add(1.0, false);
  add(3.0, false);
  add(std::nullopt, false);
  const std::vector<Layer> layers = map_layers<2>({plotted}, nullptr);
  EXPECT_THAT(names_of(layers), ElementsAre("rejected", "loop closures", "residual ≤ 2 × typical", "residual 2–4 × typical",
                                            "trajectory", "residual 4–8 × typical", "residual > 8 × typical"));
  EXPECT_TRUE(layers[0].is_dashed);
  EXPECT_EQ(layers[0].lines[0][0], Point<2>(1.0, 0.0));
  for (std::size_t k = 1; k < layers.size(); ++k) {
    EXPECT_FALSE(layers[k].is_dashed);
    EXPECT_NE(layers[k].colours, layers[0].colours);
  }
  EXPECT_EQ(layers.back().lines[0][0], Point<2>(0.0, 0.0));
}

TEST(MapLayers, HaveLinksFinerTheMoreThereAre) {
  const auto width_of = [](int links) {
    PlottedMap<2> plotted = line_of(2);
    plotted.links.resize(static_cast<std::size_t>(links), {0, PoseIndex(1), false, 99.0});
    return map_layers<2>({plotted}, nullptr).back().width;
  };
  EXPECT_EQ(width_of(100), width_of(1));
  EXPECT_LT(width_of(400), width_of(100));
  EXPECT_GT(width_of(1'000'000), 0.5);
}

TEST(MapLayers, HaveSessionsInColoursOfTheirOwnWithTheirPoses) {
  PlottedMap<2> plotted = line_of(6);
  EXPECT_THAT(names_of(map_layers<2>({plotted}, nullptr)), ElementsAre("trajectory"));
  plotted.local_maps = {{{0, 1, 0.0, 0}, {}}, {{2, 5, 0.0, 0}, {}}};
  EXPECT_THAT(names_of(map_layers<2>({plotted}, nullptr)), ElementsAre("", "local maps", "end poses"));
  plotted.sessions = {{0, 2}, {2, 6}};
  const std::vector<Layer> layers = map_layers<2>({plotted}, nullptr);
  EXPECT_THAT(names_of(layers), ElementsAre("poses 12 to 15", "poses 10 to 11"));
  EXPECT_NE(layers[0].colours, layers[1].colours);
  EXPECT_EQ(layers[0].lines[0].size(), 4U);
}

TEST(MapLayers, HaveRobotsInColoursOfTheirOwnThoughTheirOdometryHasGaps) {
  PlottedMap<2> plotted = line_of(6);
  for (const PoseIndex p : {PoseIndex(4), PoseIndex(5)}) plotted.map.pose_ids[p].session = 3;
  plotted.sessions = {{0, 2}, {2, 4}, {4, 6}};
  const std::vector<Layer> layers = map_layers<2>({plotted}, nullptr);
  EXPECT_THAT(names_of(layers), ElementsAre("session 3", "session 0"));
  EXPECT_EQ(layers[1].lines.size(), 2U);
}

TEST(MapLayers, HaveManySessionsInFiveColoursAndSayThatTheyShareThem) {
  PlottedMap<2> plotted = line_of(14);
  plotted.sessions.clear();
  for (int s = 0; s < 7; ++s) plotted.sessions.push_back({PoseIndex(2 * s), PoseIndex(2 * s + 2)});
  const std::vector<Layer> layers = map_layers<2>({plotted}, nullptr);
  EXPECT_THAT(names_of(layers), ElementsAre("poses 18 to 19", "poses 16 to 17", "poses 14 to 15", "poses 12 to 13 and others",
                                            "poses 10 to 11 and others"));
  EXPECT_EQ(layers[4].lines.size(), 2U);
  EXPECT_EQ(layers[4].lines[1][0], Point<2>(10.0, 0.0));
}

template <typename Dimension>
class PlottedTest : public ::testing::Test {};
TYPED_TEST_SUITE(PlottedTest, testing::Dimensions);

TYPED_TEST(PlottedTest, ARunHasItsClosuresAndObservations) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = testing::small_world<kDim>().log;
  const std::vector<Link> links = plotted(run(log, RunOptions{}).value(), log).links;
  ASSERT_EQ(links.size(), log.closures().size() + log.observations().size());
  for (const Link& link : links) {
    EXPECT_FALSE(link.is_rejected);
    EXPECT_LT(*link.residual, 8.0);
  }
}

TYPED_TEST(PlottedTest, OdometryAloneHasClosuresWithoutResiduals) {
  constexpr int kDim = TypeParam::value;
  const Log<kDim> log = testing::small_world<kDim>().log;
  const PlottedMap<kDim> map = plotted(log);
  ASSERT_TRUE(map.is_odometry);
  ASSERT_EQ(map.links.size(), log.closures().size());
  for (const Link& link : map.links) EXPECT_FALSE(link.residual);
}

}  // namespace
}  // namespace mapjoin::apps
