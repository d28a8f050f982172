// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <apps/picture/links.hpp>
#include <cmath>
#include <limits>
#include <tests/support/dimensions.hpp>

namespace mapjoin::apps {
namespace {

template <typename Dimension>
class LinksTest : public ::testing::Test {};
TYPED_TEST_SUITE(LinksTest, testing::Dimensions);

/// Observations of `features` features at the origin from the first of two poses there, with errors of 1, 2, … standard
/// deviations in x, which alone is measured.
template <int Dim>
struct Seen {
  GlobalMap<Dim> map;
  std::vector<FeatureFactor<Dim>> observations;

  explicit Seen(int features) {
    map.poses.resize(2);
    for (int k = 0; k < features; ++k) {
      map.features.push_back(Point<Dim>::Zero());
      PointMatrix<Dim> W = PointMatrix<Dim>::Zero();
      W(0, 0) = 4.0;
      observations.push_back({0, FeatureIndex(k), 0.5 * (k + 1) * Point<Dim>::Unit(0), W});
    }
  }
  std::vector<Link> links() const { return links_of<Dim>({}, observations, map); }
};

TYPED_TEST(LinksTest, OfFewHaveTheResidualByTheirCovariances) {
  constexpr int kDim = TypeParam::value;
  Seen<kDim> seen(19);
  for (int k = 0; k < 19; ++k) EXPECT_NEAR(*seen.links()[static_cast<std::size_t>(k)].residual, k + 1.0, 1e-12);
  seen.observations[1].information = PointMatrix<kDim>::Identity();
  EXPECT_NEAR(*seen.links()[1].residual, 1.0 / std::sqrt(kDim), 1e-12) << "of more rows more is expected";
  seen.observations[1].information.setZero();
  EXPECT_EQ(*seen.links()[1].residual, 0.0) << "nothing is measured";
}

TYPED_TEST(LinksTest, OfManyHaveTheResidualByTheTypicalOneOfTheirKind) {
  Seen<TypeParam::value> seen(21);
  const std::vector<Link> links = seen.links();
  EXPECT_NEAR(*links[20].residual / *links[0].residual, 21.0, 1e-9);
  // The median of chi-squared with one degree of freedom is 0.4549.
  EXPECT_NEAR(*links[10].residual, std::sqrt(0.4549), 1e-4);
  for (auto& o : seen.observations) o.information *= 0.01;
  EXPECT_NEAR(*seen.links()[20].residual, *links[20].residual, 1e-9) << "covariances that are all too cautious";
}

TYPED_TEST(LinksTest, WithoutErrorsAreTypical) {
  Seen<TypeParam::value> seen(30);
  for (std::size_t k = 0; k < 30; ++k) seen.observations[k].measured *= k < 20 ? 0.0 : 1e-9;
  for (const Link& link : seen.links()) EXPECT_LT(*link.residual, 0.1);
}

TYPED_TEST(LinksTest, AreClosuresThenObservationsAndNoPriors) {
  constexpr int kDim = TypeParam::value;
  Seen<kDim> seen(2);
  seen.observations[0].base = kWorld;
  std::vector<PoseFactor<kDim>> closures(2, {1, 0, {2.0 * Point<kDim>::Unit(0), {}}, PoseMatrix<kDim>::Identity()});
  closures[0].base = kWorld;
  const std::vector<Link> links = links_of<kDim>(closures, seen.observations, seen.map);
  ASSERT_EQ(links.size(), 2U);
  EXPECT_EQ(links[0].from, PoseIndex(1));
  EXPECT_EQ(links[0].to, PoseOrFeature(PoseIndex(0)));
  EXPECT_NEAR(*links[0].residual, 2.0 / std::sqrt(kPoseDof<kDim>), 1e-12);
  EXPECT_EQ(links[1].to, PoseOrFeature(FeatureIndex(1)));
}

std::string_view name_at(double residual) {
  return kLinkClasses[class_of({0, PoseIndex(1), false, residual})].name;
}

TEST(LinkClasses, DoubleFromTwiceTheTypicalResidual) {
  for (const double typical : {0.0, 0.5, 2.0}) EXPECT_EQ(name_at(typical), "residual ≤ 2 × typical");
  for (const double more : {2.01, 4.0}) EXPECT_EQ(name_at(more), "residual 2–4 × typical");
  for (const double more : {4.01, 8.0}) EXPECT_EQ(name_at(more), "residual 4–8 × typical");
  for (const double bad : {8.01, 1e9, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(name_at(bad), "residual > 8 × typical");
  }
}

TEST(LinkClasses, OfRejectedAndUnweighedLinksAreTheirOwn) {
  const std::string_view rejected = kLinkClasses[class_of({0, PoseIndex(1), true, 9.0})].name;
  EXPECT_EQ(rejected, "rejected");
  const std::string_view unweighed = kLinkClasses[class_of({0, PoseIndex(1), false, std::nullopt})].name;
  EXPECT_EQ(unweighed, "loop closures");
}

/// The CIE lightness L* of a colour "#rrggbb".
double lightness(const std::string& colour) {
  const double weights[] = {0.2126, 0.7152, 0.0722};
  double Y = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double c = std::stoi(colour.substr(1 + 2 * i, 2), nullptr, 16) / 255.0;
    Y += weights[i] * (c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return 116.0 * std::cbrt(Y) - 16.0;
}

TEST(LinkClasses, AreInOrderInBlackAndWhite) {
  for (std::size_t c = 3; c < kLinkClasses.size(); ++c) {
    EXPECT_LT(lightness(kLinkClasses[c].on_light), lightness(kLinkClasses[c - 1].on_light) - 12.0);
    EXPECT_GT(lightness(kLinkClasses[c].on_dark), lightness(kLinkClasses[c - 1].on_dark) + 12.0);
    EXPECT_GT(kLinkClasses[c].width, kLinkClasses[c - 1].width);
  }
}

}  // namespace
}  // namespace mapjoin::apps
