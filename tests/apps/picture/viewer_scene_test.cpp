// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <apps/picture/plotted_map.hpp>
#include <tests/apps/picture/viewer_page.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(ViewerPage, FindsAPoseByItsIdAndNamesIt) {
  const std::string page = page_of({folder.file("map.g2o", kNamedMap).string()});
  const Json found = found_on(page, "{at: find('35'), none: find('36'), words: find('pose'), nothing: find('')}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_THAT(found["at"]["tip"].get<std::string>(), AllOf(HasSubstr("pose 35"), HasSubstr("x 1000004.000 m")));
  EXPECT_EQ(found["at"]["text"], "");
  EXPECT_TRUE(found["at"]["isRinged"]);
  EXPECT_LT(found["at"]["fromMiddle"], 0.5) << "pixels";
  EXPECT_EQ(found["none"]["text"], "There is no pose 36.");
  EXPECT_EQ(found["words"]["text"], "There is no pose pose.");
  EXPECT_EQ(found["nothing"]["text"], "");
  for (const std::string none : {"none", "words", "nothing"}) {
    EXPECT_TRUE(found[none]["tip"].is_null());
    EXPECT_FALSE(found[none]["isRinged"]);
  }
}

/// Two robots with a pose each, of the same number.
apps::PlottedMap<2> two_poses() {
  apps::PlottedMap<2> plotted;
  plotted.map.pose_ids = {{0, 7}, {2, 7}};
  plotted.map.poses = {{{0.0, 0.0}, {}}, {{9.0, 0.0}, {}}};
  plotted.sessions = {{0, 1}, {1, 2}};
  return plotted;
}

TEST_F(ViewerPage, FindsAPoseOfASession) {
  const Json found = found_on(apps::viewer_page<2>({{two_poses()}, std::nullopt}, "robots"),
                              "{any: find('7'), that: find('pose 7 of session 2'), none: find('7 of session 1')}");
  EXPECT_THAT(found["any"]["tip"].get<std::string>(), AllOf(HasSubstr("pose 7"), Not(HasSubstr("session 2"))));
  EXPECT_THAT(found["that"]["tip"].get<std::string>(), HasSubstr("pose 7 of session 2"));
  EXPECT_EQ(found["none"]["text"], "There is no pose 7 of session 1.");
}

TEST_F(ViewerPage, FindsAPoseByTheNameThatCommandsTake) {
  apps::PlottedMap<2> plotted = two_poses();
  plotted.map.pose_ids[0] = {7, 2};  // what numbers in words, whatever stands between, would take for 2:7
  const Json found = found_on(apps::viewer_page<2>({{plotted}, std::nullopt}, "robots"),
                              "{that: find('2:7'), named: find('pose:2:7'), none: find('1:7'), sign: find('-7'), "
                              "fraction: find('2.7'), feature: find('feature:7')}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_THAT(found["that"]["tip"].get<std::string>(), HasSubstr("pose 7 of session 2"));
  EXPECT_EQ(found["named"]["tip"], found["that"]["tip"]);
  EXPECT_EQ(found["none"]["text"], "There is no pose 1:7.");
  for (const std::string none : {"none", "sign", "fraction", "feature"}) EXPECT_FALSE(found[none]["isRinged"]) << none;
}

TEST_F(ViewerPage, NamesAndFindsGtsamSymbols) {
  apps::PlottedMap<2> plotted = two_poses();
  plotted.map.pose_ids[0] = {0, *parse_key("x17")};
  plotted.map.feature_ids = {{*parse_key("l3")}};
  plotted.map.features = {{9.0, 18.0}};
  const Json found = found_on(apps::viewer_page<2>({{plotted}, std::nullopt}, "symbols"),
                              "{at: find('x17'), number: find('" + std::to_string(*parse_key("x17")) +
                                  "'), other: find('7 of session 2'), none: find('y17'), feature: tipOver(9, 18)}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_THAT(found["at"]["tip"].get<std::string>(), HasSubstr("pose x17"));
  EXPECT_EQ(found["number"]["tip"], found["at"]["tip"]);
  EXPECT_THAT(found["other"]["tip"].get<std::string>(), HasSubstr("pose 7 of session 2"));
  EXPECT_EQ(found["none"]["text"], "There is no pose y17.");
  EXPECT_THAT(found["feature"].get<std::string>(), HasSubstr("feature l3"));
}

TEST_F(ViewerPage, DrawsRejectedLinksApartAndDashed) {
  apps::PlottedMap<2> plotted = two_poses();
  plotted.map.feature_ids = {{5}};
  plotted.map.features = {{9.0, 18.0}};
  plotted.links = {{0, FeatureIndex(0), true, 1.0}, {0, PoseIndex(1), false, 1.0}};
  const Json found =
      found_on(apps::viewer_page<2>({{plotted}, std::nullopt}, "links"),
               "{rejected: pointsOf(layerNamed('rejected')), kept: pointsOf(layerNamed('residual ≤ 2 × typical'))}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_EQ(found["kept"], Json({-4.5, 0, 0, 4.5, 0, 0}));
  ASSERT_EQ(found["rejected"].size(), 6U * 5U);
  for (const std::size_t dash : {0U, 4U}) {
    const auto at = [&](std::size_t i) { return found["rejected"][6 * dash + i].get<double>(); };
    EXPECT_NEAR(at(0), -4.5 + 2.0 * static_cast<double>(dash), 1e-5);
    EXPECT_NEAR(at(1), 4.0 * static_cast<double>(dash), 1e-5);
    EXPECT_NEAR(at(3), at(0) + 1.0, 1e-5);
    EXPECT_NEAR(at(4), at(1) + 2.0, 1e-5);
  }
}

/// Three poses on a line of a session, two local maps.
apps::PlottedMap<2> line_of_poses(const std::string& name) {
  apps::PlottedMap<2> plotted;
  plotted.name = name;
  plotted.map.pose_ids = {{0, 1}, {0, 2}, {0, 3}};
  plotted.map.poses = {{{0.0, 0.0}, {}}, {{4.0, 0.0}, {}}, {{8.0, 0.0}, {}}};
  plotted.sessions = {{0, 3}};
  plotted.local_maps = {{{0, 1, 1.0, 3}, {}}, {{1, 2, 1.0, 3}, {}}};
  return plotted;
}

TEST_F(ViewerPage, DrawsATruthOfSinglePoses) {
  const apps::PlottedMap<2> plotted = line_of_poses("map");
  const Truth<2> truth = {{Pose<2>{{0.0, 2.0}, {}}, std::nullopt, Pose<2>{{8.0, 2.0}, {}}}, {}};
  const Json found = found_on(apps::viewer_page<2>({{plotted}, truth}, "truth"), "{layers: switchLayers()}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_EQ(found["layers"][0]["name"], "truth");
  EXPECT_TRUE(found["layers"][0]["changes"]);
}

TEST_F(ViewerPage, MovesAndZoomsByKeys) {
  const Json found = found_on(apps::viewer_page<2>({{line_of_poses("map")}, std::nullopt}, "keys"),
                              "{left: press(1, {keyCode: 37}), nearer: press(1, {key: '+'}), farther: press(1, {key: '-'})}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_NEAR(found["left"]["after"][0].get<double>() - found["left"]["before"][0].get<double>(), 40.0, 0.5) << "pixels";
  EXPECT_NEAR(found["nearer"]["share"], 1.25, 1e-9);
  EXPECT_NEAR(found["farther"]["share"], 0.8, 1e-9);
  EXPECT_NEAR(found["farther"]["after"][0], found["nearer"]["before"][0], 0.5);
}

TEST_F(ViewerPage, OffersOnlyLocalMapsThatAClickPicks) {
  apps::PlottedMap<2> second = line_of_poses("second");
  for (Pose<2>& pose : second.map.poses) pose.translation.y() += 6.0;
  const Json found = found_on(apps::viewer_page<2>({{line_of_poses("first"), second}, std::nullopt}, "two"),
                              "{first: tipOver(4, 0), second: tipOver(4, 6)}");
  EXPECT_THAT(found["first"].get<std::string>(), AllOf(HasSubstr("first"), HasSubstr("local map 2, click to pick it")));
  EXPECT_THAT(found["second"].get<std::string>(),
              AllOf(HasSubstr("second"), HasSubstr("local map 2"), Not(HasSubstr("click"))));
}

}  // namespace
}  // namespace mapjoin::testing
