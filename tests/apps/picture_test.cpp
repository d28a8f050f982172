// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <apps/picture.hpp>
#include <cmath>
#include <string_view>

namespace mapjoin::apps {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// Round and round, ever wider.
std::vector<Pose<2>> spiral(std::size_t poses) {
  std::vector<Pose<2>> path;
  for (std::size_t k = 0; k < poses; ++k) {
    const double t = static_cast<double>(k);
    path.push_back({Point<2>(t * std::cos(t), t * std::sin(t)), Rotation<2>(t)});
  }
  return path;
}

TEST(Picture, DrawsEveryLayerOverTheOneBefore) {
  const auto path = spiral(20);
  const std::vector<Point<2>> features = {{1.0, 2.0}, {3.0, 4.0}};
  const std::vector<Layer<2>> layers = {{"first & last", "red", &path, &features, 1.0, Mark::kRing},
                                        {"second", "blue", &path, nullptr}};
  const std::string svg = picture(layers, {{0, 10}, {10, 20}});
  EXPECT_EQ(count(svg, "<polyline"), 4U);  // two sessions each
  EXPECT_LT(svg.find("stroke=\"red\" stroke-width"), svg.find("stroke=\"blue\" stroke-width"));
  EXPECT_THAT(svg, HasSubstr("first &amp; last</text>"));
  EXPECT_LT(svg.find("second</text>"), svg.find("first &amp; last</text>"));
  EXPECT_EQ(count(svg, "r=\"4.5\""), 2U);
}

TEST(Picture, IsBoundedHoweverLargeTheMap) {
  const auto path = spiral(200'000);
  std::vector<Point<2>> features;
  features.reserve(path.size());
  for (const Pose<2>& pose : path) features.push_back(pose.translation);
  const std::vector<Layer<2>> line = {{"long", "red", &path, nullptr}};
  EXPECT_LT(picture(line, {{0, 200'000}}).size(), 200'000U);
  const std::vector<Layer<2>> dots = {{"many", "red", nullptr, &features}};
  EXPECT_LT(picture(dots, {}).size(), 500'000U);
}

TEST(Picture, HoldsWhatIsFramedAndCutsTheRest) {
  const auto near = spiral(10);
  const auto far = spiral(1000);
  const auto scale_of = [](const std::string& svg) { return svg.substr(svg.find(" m</text>") - 4, 4); };
  const std::vector<Layer<2>> alone = {{"near", "red", &near, nullptr}};
  const std::vector<Layer<2>> cut = {{"far", "red", &far, nullptr, 1.0, Mark::kDot, false}, {"near", "red", &near, nullptr}};
  const std::vector<Layer<2>> whole = {{"far", "red", &far, nullptr}, {"near", "red", &near, nullptr}};
  EXPECT_EQ(scale_of(picture(cut, {{0, 10}})), scale_of(picture(alone, {{0, 10}})));
  EXPECT_NE(scale_of(picture(whole, {{0, 10}})), scale_of(picture(alone, {{0, 10}})));
}

TEST(Picture, OfNothingIsOneMetre) {
  const std::vector<Pose<3>> still(3);
  const std::vector<Layer<3>> layers = {{"still", "red", &still, nullptr}};
  const std::string svg = picture(layers, {{0, 3}});
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, HasSubstr("0.2 m</text>"));
}

}  // namespace
}  // namespace mapjoin::apps
