// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <apps/chart.hpp>
#include <cmath>
#include <limits>

namespace mapjoin::apps {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> labels(const Axis& axis, const std::vector<double>& values) {
  std::vector<std::string> words;
  const Scale scale(axis, values);
  for (const Tick& tick : scale.ticks()) words.push_back(tick.label);
  return words;
}

Axis logarithmic() {
  Axis axis;
  axis.is_logarithmic = true;
  return axis;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

Chart chart_of(std::vector<CurvePoint> points) {
  Chart chart;
  chart.curves.push_back({.name = "a curve", .points = std::move(points)});
  return chart;
}

TEST(ChartScale, HasTicksAtOneTwoFive) {
  EXPECT_THAT(labels({}, {0.0, 1.0}), ElementsAre("0.0", "0.2", "0.4", "0.6", "0.8", "1.0"));
  EXPECT_THAT(labels({}, {3.0, 28.0}), ElementsAre("0", "5", "10", "15", "20", "25", "30"));
  EXPECT_THAT(labels({}, {-0.011, 0.013}), ElementsAre("-0.015", "-0.010", "-0.005", "0.000", "0.005", "0.010", "0.015"));
}

TEST(ChartScale, HasAFactorWhereNumbersAreLong) {
  const Scale scale({}, {1.4e8, 2.3e8});
  EXPECT_EQ(scale.factor(), "×10⁸");
  EXPECT_EQ(scale.ticks().front().label, "1.4");
  EXPECT_EQ(Scale({}, {1e-12, 4e-12}).factor(), "×10⁻¹²");
  EXPECT_EQ(Scale({}, {0.0, 99999.0}).factor(), "×10⁵");
  EXPECT_EQ(Scale({}, {0.0, 70000.0}).factor(), "");
}

TEST(ChartScale, HasTicksAtDecadesWhereLogarithmic) {
  EXPECT_THAT(labels(logarithmic(), {3e-4, 8e3}), ElementsAre("10⁻⁴", "10⁻²", "10⁰", "10²", "10⁴"));
  EXPECT_THAT(labels(logarithmic(), {1.0, 30.0}), ElementsAre("1", "2", "5", "10", "20", "50"));
  EXPECT_THAT(labels(logarithmic(), {2e6, 4e6}), ElementsAre("2·10⁶", "5·10⁶"));
}

TEST(ChartScale, TakesNoZeroWhereLogarithmic) {
  const Scale scale(logarithmic(), {0.0, -3.0, kNaN, 10.0, 1000.0});
  EXPECT_FALSE(scale.takes(0.0));
  EXPECT_DOUBLE_EQ(scale.share(10.0), 0.0);
  EXPECT_DOUBLE_EQ(scale.share(100.0), 0.5);
  EXPECT_DOUBLE_EQ(scale.share(1000.0), 1.0);
}

TEST(ChartScale, KeepsTheEndsItIsGiven) {
  Axis axis;
  axis.low = 0.3;
  axis.high = 1.7;
  const Scale scale(axis, {-100.0, 100.0});
  EXPECT_DOUBLE_EQ(scale.share(0.3), 0.0);
  EXPECT_DOUBLE_EQ(scale.share(1.7), 1.0);
  EXPECT_THAT(labels(axis, {}), ElementsAre("0.5", "1.0", "1.5"));
}

TEST(ChartScale, MakesRoomAroundOneValueAndNone) {
  for (const std::vector<double>& values : {std::vector<double>{}, {5.0, 5.0}, {0.0}, {-1e-12}, {1e300, -1e300}, {1e308}}) {
    for (const Axis& axis : {Axis{}, logarithmic()}) {
      const Scale scale(axis, values);
      EXPECT_GE(scale.ticks().size(), 2U);
      for (const Tick& tick : scale.ticks()) {
        EXPECT_GE(scale.share(tick.value), -1e-6);
        EXPECT_LE(scale.share(tick.value), 1.0 + 1e-6);
      }
    }
  }
}

TEST(Chart, BreaksTheLineWhereAPointIsNotFinite) {
  const std::string whole = svg(chart_of({{0, 0}, {1, 1}, {2, 4}, {3, 9}}));
  const std::string broken = svg(chart_of({{0, 0}, {1, 1}, {2, kNaN}, {3, 9}}));
  EXPECT_EQ(count(whole, "h0"), 1U);  // where a line begins
  EXPECT_EQ(count(broken, "h0"), 2U);
  EXPECT_THAT(broken, Not(HasSubstr("nan")));
}

TEST(Chart, PutsPointsWhereTheAxesSay) {
  Chart chart = chart_of({{0, 0}, {1, 1}});
  chart.curves.front().has_markers = true;
  chart.width = 418.0 + 18.0 + 3 * 0.58 * 12.0;  // margins, and labels of three characters: the plot is 400 wide
  chart.height = 80.0 + 200.0;
  const std::string picture = svg(chart);
  EXPECT_THAT(picture, HasSubstr("cx=\"0.0\" cy=\"200.0\""));
  EXPECT_THAT(picture, HasSubstr("cx=\"400.0\" cy=\"0.0\""));
}

TEST(Chart, CutsOffWhatLiesBeyondTheEndsOfAnAxis) {
  Chart chart = chart_of({{0, 0}, {1, 7}});
  EXPECT_THAT(svg(chart), Not(HasSubstr("hidden")));
  chart.y.high = 7.0;
  EXPECT_THAT(svg(chart), Not(HasSubstr("hidden")));
  chart.y.high = 5.0;
  EXPECT_THAT(svg(chart), HasSubstr("hidden"));
}

TEST(Chart, DrawsABandWherePointsHaveOne) {
  EXPECT_EQ(count(svg(chart_of({{0, 1}, {1, 2}})), "fill-opacity"), 0U);
  const std::string picture = svg(chart_of({{0, 1, 0.5, 1.5}, {1, 2, 1, 3}, {2, 3}, {3, 4, 3, 5}, {4, 5, 4, 6}}));
  EXPECT_EQ(count(picture, "fill-opacity"), 1U);
  EXPECT_EQ(count(picture, "Z"), 2U);  // one area on either side of the point without
}

TEST(Chart, DrawsBarsAtMarkersThatHaveThem) {
  Chart chart = chart_of({{0, 1, 0.5, 1.5}, {1, 2, 1, 3}, {2, 3}});
  chart.curves.front().has_markers = true;
  const std::string picture = svg(chart);
  EXPECT_EQ(count(picture, "fill-opacity"), 0U);
  const auto bars = picture.substr(picture.rfind("<path", picture.find("stroke-opacity")));
  EXPECT_EQ(count(bars.substr(0, bars.find('\n')), "V"), 2U);
}

TEST(Chart, EscapesItsText) {
  Chart chart = chart_of({{0, 1}});
  chart.title = "a < b & \"c\" > d";
  EXPECT_THAT(svg(chart), HasSubstr("a &lt; b &amp; &quot;c&quot; &gt; d"));
}

TEST(Chart, HasALegendBelowThePlotOfTheCurvesThatHaveNames) {
  Chart chart = chart_of({{0, 1}, {1, 2}});
  chart.curves.push_back({.name = "", .points = {{0, 2}, {1, 3}}});
  const std::string picture = svg(chart);
  EXPECT_EQ(count(picture, "text-anchor=\"start\""), 1U);
  EXPECT_THAT(picture, HasSubstr("y=\"332.0\" text-anchor=\"start\">a curve<"));
}

TEST(Chart, GivesEveryCurveAColourUnlessTold) {
  Chart chart = chart_of({{0, 1}, {1, 2}});
  chart.curves.push_back(chart.curves.front());
  EXPECT_THAT(svg(chart), HasSubstr("#d55e00"));
  chart.curves.back().colour = 0;
  EXPECT_THAT(svg(chart), Not(HasSubstr("#d55e00")));
}

TEST(Chart, StandsBesideOthers) {
  const std::vector<Chart> charts(3, chart_of({{0, 1}, {1, 2}}));
  const std::string panels = svg(charts, 2);
  EXPECT_THAT(panels, HasSubstr("viewBox=\"0 0 960 686\""));
  EXPECT_THAT(panels, HasSubstr("translate(480.0 0.0)"));
  EXPECT_THAT(panels, HasSubstr("translate(0.0 338.0)"));
  EXPECT_EQ(panels, svg(charts, 2));
  EXPECT_THAT(svg(std::vector<Chart>{}, 2), HasSubstr("</svg>"));
}

}  // namespace
}  // namespace mapjoin::apps
