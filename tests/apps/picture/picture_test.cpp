// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <apps/picture/picture.hpp>
#include <cmath>
#include <numbers>
#include <string_view>
#include <tests/apps/command.hpp>

namespace mapjoin::apps {
namespace {

using testing::count_of;
using ::testing::HasSubstr;
using ::testing::Not;

/// A spiral, a radian and a metre of radius from point to point.
FlatLine spiral(std::size_t points) {
  FlatLine path;
  for (std::size_t k = 0; k < points; ++k) {
    const double t = static_cast<double>(k);
    path.emplace_back(t * std::cos(t), t * std::sin(t));
  }
  return path;
}

Layer line(const std::string& name, const std::string& colour, FlatLine points) {
  return {name, {colour}, {std::move(points)}, {}, {}};
}

TEST(Picture, DrawsEveryLayerOverTheOneBefore) {
  Layer first = line("first & last", "red", spiral(20));
  first.marks = {{1.0, 2.0}, {3.0, 4.0}};
  first.mark = Mark::kRing;
  const std::string svg = picture({first, line("second", "blue", spiral(20)), line("", "green", spiral(20))});
  EXPECT_LT(svg.find("stroke=\"red\" stroke-width"), svg.find("stroke=\"blue\" stroke-width"));
  EXPECT_THAT(svg, HasSubstr("first &amp; last</text>"));
  EXPECT_LT(svg.find("second</text>"), svg.find("first &amp; last</text>"));
  EXPECT_EQ(count_of(svg, "</text>"), 3U);  // scale and two names: a layer without one is not in the legend
  EXPECT_EQ(count_of(svg, "r=\"4.5\""), 3U);
}

TEST(Picture, SinglePosesOfADashedPathAreWholeDotsBesideIt) {
  Layer layer{"", {"red"}, {{{0.0, 0.0}}, {{1.0, 0.0}, {4.0, 0.0}}}, {}, {}};
  layer.is_dashed = true;
  const std::string svg = picture({layer}, 480.0);
  EXPECT_EQ(count_of(svg, "stroke-dasharray"), 1U);
  EXPECT_THAT(svg, HasSubstr("d=\"M40.0,40.0h0\""));
}

TEST(Picture, ALegendShortensNamesThatAreWiderThanThePicture) {
  const std::string long_name = "first" + std::string(500, '-') + "läst";
  const std::string svg =
      picture({line(long_name, "red", spiral(20)), line("3σ of features (capped at the map's size)", "blue", {})});
  EXPECT_THAT(svg, HasSubstr(">first--"));
  EXPECT_THAT(svg, HasSubstr("-…-"));
  EXPECT_THAT(svg, HasSubstr("--läst</text>"));
  EXPECT_THAT(svg, Not(HasSubstr(std::string(140, '-'))));
  const std::string narrow = picture({line("3σ of features (capped at the map's size)", "red", {{0.0, 0.0}, {0.0, 9.0}})});
  EXPECT_THAT(narrow, HasSubstr(">3σ of features (capped at the map's size)</text>"));
}

TEST(Picture, LinesOfALayerTakeItsColoursInTurn) {
  const Layer layer{"", {"red", "blue"}, {{{0, 0}, {1, 0}}, {{1, 0}, {2, 0}}, {{2, 0}, {4, 0}}}, {}, {}};
  const std::string svg = picture({layer}, 480.0);
  EXPECT_THAT(svg, HasSubstr("M40.0,40.0 140.0,40.0M240.0,40.0 440.0,40.0\" fill=\"none\" stroke=\"red\""));
  EXPECT_THAT(svg, HasSubstr("M140.0,40.0 240.0,40.0\" fill=\"none\" stroke=\"blue\""));
}

TEST(Picture, IsBoundedHoweverLargeTheMap) {
  const FlatLine path = spiral(200'000);
  EXPECT_LT(picture({line("long", "red", path)}).size(), 200'000U);
  Layer many{"many", {"red"}, {}, path, {}};
  EXPECT_LT(picture({many}).size(), 500'000U);
  for (const Point<2>& p : path) many.lines.push_back({p, p + Point<2>(1.0, 0.0)});
  many.marks.clear();
  EXPECT_LT(picture({many}).size(), 500'000U);
}

TEST(Picture, OfVeryManyLocalMapsNoneIsLeftOut) {
  Layer maps{"maps", {"red", "blue"}, {}, {}, {}};
  for (int k = 0; k < 12'000; ++k) maps.lines.push_back({{1.0 * k, 0.0}, {k + 0.5, 0.5}, {k + 1.0, 0.0}});
  const std::string svg = picture({maps}, 100'080.0);
  EXPECT_LT(svg.size(), 500'000U);
  double covered = 0.0;
  for (std::size_t at = svg.find('M'); at != std::string::npos; at = svg.find('M', at + 1)) {
    const std::string line = svg.substr(at + 1, svg.find_first_of("M\"", at + 1) - at - 1);
    if (line.find(',') != std::string::npos) covered += std::stod(line.substr(line.rfind(' ') + 1)) - std::stod(line);
  }
  EXPECT_NEAR(covered, 100'000.0, 1.0) << "pixels";
}

TEST(Picture, IsBoundedInHoweverManyPiecesItsPathIs) {
  Layer layer = line("map", "red", {});
  layer.lines.clear();
  for (int piece = 0; piece < 30'000; ++piece) {
    const double x = 10.0 * piece;
    for (const double y : {0.0, 1.0, 2.0}) layer.lines.push_back({{x, y}, {x, y + 1.0}});
  }
  EXPECT_LE(count_of(picture({layer}), "M"), 10'010U);
}

TEST(Picture, HoldsWhatIsFramedAndCutsTheRest) {
  const auto scale_of = [](const std::string& svg) { return svg.substr(svg.find(" m</text>") - 4, 4); };
  const Layer near = line("near", "red", spiral(10));
  Layer far = line("far", "red", spiral(1000));
  const std::string alone = scale_of(picture({near}));
  EXPECT_NE(scale_of(picture({far, near})), alone);
  far.is_framed = false;
  EXPECT_EQ(scale_of(picture({far, near})), alone);
}

TEST(Picture, HoldsItsEllipses) {
  Layer layer = line("path", "red", {{0.0, 0.0}, {8.0, 0.0}});
  layer.ellipses = {{{8.0, 0.0}, {4.0, 1.0}, std::numbers::pi / 2.0}};
  const std::string svg = picture({layer}, 980.0);
  EXPECT_THAT(svg, HasSubstr("M40.0,440.0 840.0,440.0"));  // from -4 to 4 m across the path, and 1 m beyond its end
  EXPECT_THAT(svg, HasSubstr("<svg width=\"980\" height=\"880.0\">"));
}

TEST(Picture, OfNothingIsOneMetre) {
  const std::string svg = picture({line("still", "red", FlatLine(3, Point<2>::Zero()))});
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, HasSubstr("0.2 m</text>"));
}

TEST(Picture, APathOfOnePoseIsADot) {
  const std::string svg = picture({line("one", "red", {{0.0, 0.0}}), line("far", "blue", {{-1.0, 0.0}, {1.0, 0.0}})}, 480.0);
  EXPECT_THAT(svg, HasSubstr("<path d=\"M240.0,40.0h0\" fill=\"none\" stroke=\"red\" stroke-width=\"4.4\""));
  EXPECT_THAT(svg, HasSubstr("stroke-linecap=\"round\""));
}

TEST(Picture, AnEllipseIsWhereTheMahalanobisDistanceIsSoMany) {
  const Matrix<2> P = (Matrix<2>() << 4.0, -1.5, -1.5, 1.0).finished();
  const Ellipse e = ellipse({1.0, 2.0}, P, 3.0);
  const Rotation<2> turn(e.angle);
  for (double t = 0.0; t < 6.3; t += 0.1) {
    const Point<2> d = turn.matrix() * Point<2>(e.half_axes.x() * std::cos(t), e.half_axes.y() * std::sin(t));
    EXPECT_NEAR(d.dot(P.inverse() * d), 9.0, 1e-9);
  }
}

TEST(Picture, AnEllipseOfACertainPlaceIsAPoint) {
  EXPECT_EQ(ellipse({1.0, 2.0}, Matrix<2>::Zero(), 3.0).half_axes.norm(), 0.0);
}

}  // namespace
}  // namespace mapjoin::apps
