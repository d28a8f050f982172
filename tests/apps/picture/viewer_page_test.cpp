// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <tests/apps/picture/viewer_page.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(ViewerPage, DrawsAndSwitchesItsLayersWithoutComplaint) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("run"), "--covariances", "--quiet"}).exit_code, 0);
  const std::string page = page_of({path("run"), "--truth", kBundledTruth});
  const Json found = found_on(page, "{picture: fingerprint(), layers: switchLayers()}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_GT(found["picture"], 0);
  std::vector<std::string> names;
  for (const Json& layer : found["layers"]) {
    names.push_back(layer["name"]);
    // Poses are drawn as dots only from near; the trajectory, off at first, lies below its local maps.
    const bool is_seen = names.back() != "poses" && names.back() != "trajectory";
    EXPECT_EQ(layer["changes"], is_seen) << layer;
    EXPECT_TRUE(layer["comesBack"]) << layer;
  }
  EXPECT_THAT(names,
              ::testing::ElementsAre("truth", "end poses", "local maps", "poses", "trajectory", "features", "3σ of poses",
                                     "3σ of features", "residual 2–4 × typical", "residual ≤ 2 × typical", "odometry alone"));
}

/// The covariances of kNamedMap, all zero.
Json covariances_of_named_map() {
  Json covariances = {{"dimension", 2}, {"poses", Json::array()}, {"features", Json::array()}};
  const auto add = [&](const char* things, Json line, double x, double y, std::size_t numbers) {
    line["position"] = {x, y};
    line["covariance"] = std::vector<double>(numbers);
    covariances[things].push_back(line);
  };
  add("poses", {{"session", 0}, {"pose", 10}}, 1000000, 5, 6);
  add("poses", {{"session", 0}, {"pose", 20}}, 1000004, 5, 6);
  add("poses", {{"session", 0}, {"pose", 35}}, 1000004, 9, 6);
  add("poses", {{"session", 0}, {"pose", 41}}, 1000000, 9, 6);
  add("features", {{"feature", 700}}, 1000002, 7, 3);
  add("features", {{"feature", 800}}, 1000006, 10, 3);
  return covariances;
}

TEST_F(ViewerPage, DrawsEllipsesNoLargerThanTheMap) {
  folder.file("map.g2o", kNamedMap);
  Json covariances = covariances_of_named_map();
  covariances["poses"][3]["covariance"] = {1e6, 0, 0, 1e6, 0, 0};
  folder.file("map.covariances.json", covariances.dump());
  const std::string probe = "{points: pointsOf(layerNamed(\"3σ of poses (capped at the map's size)\")).map(Math.abs)}";
  const auto points = found_on(page_of({path("map.g2o")}), probe)["points"].get<std::vector<double>>();
  EXPECT_NEAR(*std::ranges::max_element(points), 2.0 + 0.5 * 6.0, 1e-3);  // pose 41 is 2 m from the middle of a map of 6 m
}

TEST_F(ViewerPage, HasSessionsInColoursOfTheirOwn) {
  const std::string map =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 4 0 0\nVERTEX_SE2 2 0 3 0\nVERTEX_SE2 3 4 3 0\nEDGE_SE2 0 1 4 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 2 3 4 0 0 1 0 0 1 0 1\nEDGE_SE2 0 2 0 3 0 1 0 0 1 0 1\nEDGE_SE2 0 3 90 3 0 1 0 0 1 0 1\n";
  const Json found = found_on(page_of({folder.file("map.g2o", map).string()}), "{layers: switchLayers()}");
  std::vector<std::string> names, colours;
  for (const Json& layer : found["layers"]) {
    names.push_back(layer["name"]);
    colours.push_back(layer["colour"]);
    EXPECT_EQ(layer["changes"], names.back() != "odometry alone") << layer;  // odometry alone lies below the trajectory
  }
  EXPECT_THAT(names, ::testing::ElementsAre("residual > 8 × typical", "poses", "poses 0 to 1", "poses 2 to 3",
                                            "residual ≤ 2 × typical", "odometry alone"));
  EXPECT_NE(colours[2], colours[3]);
}

TEST_F(ViewerPage, MovesSmoothlyWithAHundredThousandPoses) {
  std::string map;
  for (int k = 0; k < 100000; ++k) {
    const double turn = 0.01 * k;
    map += fmt::format("VERTEX_SE2 {} {} {} {}\n", k, 0.5 * turn * std::cos(turn), 0.5 * turn * std::sin(turn), turn);
    if (k > 0) map += fmt::format("EDGE_SE2 {} {} 1 0 0.01 1 0 0 1 0 1\n", k - 1, k);
    const double x = 0.5 * turn * std::cos(turn) + std::cos(turn) - std::sin(turn);
    const double y = 0.5 * turn * std::sin(turn) + std::sin(turn) + std::cos(turn);
    if (k % 5 == 0) map += fmt::format("VERTEX_XY {} {} {}\n", 200000 + k, x, y);
    if (k % 5 == 0) map += fmt::format("EDGE_SE2_XY {} {} 1 1 1 0 1\n", k, 200000 + k);
  }
  const Json found = found_on(page_of({folder.file("map.g2o", map).string()}), "moveAndRest()");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_TRUE(found["comesBack"]) << "the whole map after a move";
  std::cout << "a frame, at rest and in motion: " << found["atRest"] << ", " << found["inMotion"] << '\n';
  EXPECT_EQ(found["atRest"]["points"], 20000);
  EXPECT_EQ(found["atRest"]["lines"], 99999 + 20000);  // of the trajectory and of observations
  EXPECT_LE(found["inMotion"]["points"], 4000);
  EXPECT_LE(found["inMotion"]["lines"], 2 * 4000);
  EXPECT_GT(found["inMotion"]["lines"], 0);
}

TEST_F(ViewerPage, TellsWhatIsUnderThePointer) {
  const std::string page = page_of({folder.file("map.g2o", kNamedMap).string()});
  const Json found = found_on(page, "{pose: tipOver(1000004, 9), feature: tipOver(1000006, 10), nothing: tipOver(1000001, 8)}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_THAT(found["pose"].get<std::string>(), AllOf(HasSubstr("pose 35"), HasSubstr("x 1000004.000 m, y 9.0000 m")));
  EXPECT_THAT(found["feature"].get<std::string>(), AllOf(HasSubstr("feature 800"), HasSubstr("x 1000006.000 m")));
  EXPECT_TRUE(found["nothing"].is_null());
}

TEST_F(ViewerPage, TellsHowCertainThatIs) {
  folder.file("map.g2o", kNamedMap);
  Json covariances = covariances_of_named_map();
  covariances["poses"][3]["covariance"] = {0.25, 0.01, 0, 0.04, 0, 0.0001};
  covariances["features"][0]["covariance"] = {1, 0.5, 4};
  folder.file("map.covariances.json", covariances.dump());
  const Json found = found_on(page_of({path("map.g2o")}), "{pose: tipOver(1000000, 9), feature: tipOver(1000002, 7)}");
  EXPECT_THAT(found["pose"].get<std::string>(),
              AllOf(HasSubstr("pose 41"), HasSubstr("σx 0.500 m, σy 0.200 m, σφ 0.573°"), HasSubstr("1.00e-2")));
  EXPECT_THAT(found["feature"].get<std::string>(), AllOf(HasSubstr("feature 700"), HasSubstr("σx 1.00 m, σy 2.00 m")));
}

TEST_F(ViewerPage, MovesWithThePointerAndZoomsUnderIt) {
  const std::string page = page_of({folder.file("map.g2o", kNamedMap).string()});
  const Json found = found_on(page, "{zoomed: zoomOver(2), dragged: drag(1, 70, -30)}");
  EXPECT_EQ(found["errors"], Json::array());
  EXPECT_GT(found["zoomed"]["share"], 1.05);
  for (const std::size_t i : {0u, 1u}) {
    const auto moved = [&](const std::string& by) {
      return found[by]["after"][i].get<double>() - found[by]["before"][i].get<double>();
    };
    EXPECT_NEAR(moved("zoomed"), 0.0, 0.5);
    EXPECT_NEAR(moved("dragged"), i == 0 ? 70.0 : -30.0, 0.5);
  }
}

TEST_F(ViewerPage, TurnsAMapInSpace) {
  const std::string map =
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 4 0 0 0 0 0 1\nVERTEX_SE3:QUAT 2 4 3 0 0 0 0 1\n"
      "VERTEX_SE3:QUAT 3 4 3 9 0 0 0 1\n";
  const Json found = found_on(page_of({folder.file("map.g2o", map).string()}),
                              "{dragged: [0, 3].map((pose) => drag(pose, 90, 0)), "
                              "tip: tipOver(4, 3, 9)}");
  EXPECT_EQ(found["errors"], Json::array());
  // The map turns about a vertical axis, and poses at different places move sideways by different distances.
  const auto aside = [&](std::size_t k) {
    return found["dragged"][k]["after"][0].get<double>() - found["dragged"][k]["before"][0].get<double>();
  };
  EXPECT_GT(std::abs(aside(0) - aside(1)), 1.0);
  EXPECT_THAT(found["tip"].get<std::string>(), AllOf(HasSubstr("pose 3"), HasSubstr("z 9.0000 m")));
}

TEST_F(ViewerPage, PicksALocalMapAndSaysHowItFits) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("run"), "--quiet"}).exit_code, 0);
  const Json map = Json::parse(content_of(path("run/report.json")))["join"]["maps"][6];
  const Json found =
      found_on(page_of({path("run")}), "{whole: fingerprint(), picked: pickLocalMap(7), none: pickLocalMap('')}");
  EXPECT_EQ(found["errors"], Json::array());
  const std::string words = found["picked"]["text"].dump();
  EXPECT_THAT(words, HasSubstr(map["pose"].dump() + " to " + map["end"].dump()));
  EXPECT_THAT(words, HasSubstr(map["chi2"].dump().substr(0, 4)));
  EXPECT_NE(found["picked"]["picture"], found["whole"]);
  EXPECT_EQ(found["none"]["picture"], found["whole"]);
}

TEST_F(ViewerPage, JoinsMapAfterMap) {
  for (const std::string log : {"manhattan2d.g2o", "manhattan3d.g2o"}) {
    ASSERT_EQ(call({"build", (kBundledData / log).string(), "-o", path("maps"), "--poses-per-map", "50"}).exit_code, 0);
    const Json found = found_on(page_of({path("maps")}),
                                "{whole: fingerprint(), first: slideTo(0), third: slideTo(2), last: slideTo(99), "
                                "found: (slideTo(0), find('3')), text: document.getElementById('stop-text').textContent}");
    EXPECT_EQ(found["errors"], Json::array());
    const std::string maps = log == "manhattan2d.g2o" ? "20" : "8";
    EXPECT_THAT(found["first"]["text"].get<std::string>(), HasSubstr("1 of " + maps + " maps, chi2"));
    EXPECT_THAT(found["third"]["text"].get<std::string>(), HasSubstr("3 of " + maps + " maps, chi2"));
    EXPECT_EQ(found["last"]["text"], "all " + maps + " maps: the whole map");
    EXPECT_NE(found["first"]["picture"], found["third"]["picture"]);
    EXPECT_EQ(found["last"]["picture"], found["whole"]);
    EXPECT_EQ(found["text"], found["last"]["text"]) << "a pose is found in the whole map";
  }
}

TEST_F(ViewerPage, SaysSoWhereTheBrowserHasNoWebGL) {
  const std::string page = page_of({folder.file("map.g2o", kNamedMap).string()});
  const std::string shown = "{text: document.body.innerText}";
  const Json without = found_on(page, shown, "--disable-3d-apis");
  EXPECT_EQ(without["errors"], Json::array());
  EXPECT_THAT(without["text"].get<std::string>(), AllOf(HasSubstr("this browser has no WebGL"), Not(HasSubstr("Layers"))));
  EXPECT_THAT(found_on(page, shown)["text"].get<std::string>(), AllOf(HasSubstr("Layers"), Not(HasSubstr("WebGL"))));
}

TEST_F(ViewerPage, FetchesNothingAndTakesNamesAsText) {
  const std::string page = page_of({folder.file("<b>&amp.g2o", kNamedMap).string()});
  EXPECT_THAT(page, Not(HasSubstr("<b>&amp")));
  EXPECT_EQ(page.find(" src="), std::string::npos);
  EXPECT_EQ(page.find("<link"), std::string::npos);
  const Json found = found_on(page, "{title: document.getElementById('title').textContent}");
  EXPECT_EQ(found["title"], "<b>&amp.g2o");
}

}  // namespace
}  // namespace mapjoin::testing
