// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/join/association/matching/neighbour_density.hpp>
#include <numbers>
#include <span>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin {
namespace {

using Points = std::vector<Point<2>>;

const Points kSeenTogether = {{0.0, 0.0}, {1.6, 0.3}, {3.9, -0.4}, {5.2, 2.8}, {1.1, 4.7}, {7.9, 1.2}};

TEST(NeighbourDensityTest, IsThatOfANormalDistribution) {
  Points grid;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) grid.emplace_back(3.0 * x, 3.0 * y);
  }
  const NeighbourDensity<2> density(std::vector<Points>(20, grid));
  for (const double distance : {2.0, 3.0, 4.0}) {
    const double variance = 0.5 * distance * distance;
    double expected = 0.0;
    for (const auto& from : grid) {
      for (const auto& to : grid) {
        const double likelihood = std::exp(-0.5 * (to - from).squaredNorm() / variance) / (2.0 * std::numbers::pi * variance);
        if (to != from) expected += likelihood / static_cast<double>(grid.size());
      }
    }
    EXPECT_NEAR(density.log_within(0.0, variance), std::log(expected), 0.15) << distance;
    EXPECT_NEAR(density.log_within(variance, 0.5 * variance), density.log_within(0.0, variance), 1e-12);
  }
}

TEST(NeighbourDensityTest, KnowsThatFeaturesKeepTheirDistance) {
  Points grid;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) grid.emplace_back(3.0 * x, 3.0 * y);
  }
  const std::vector<Points> sets(20, grid);
  const NeighbourDensity<2> density(sets);
  EXPECT_NEAR(density.overall(), 1.0 / 9.0, 0.03);
  EXPECT_LT(density.log_within(1.0 * 1.0, 0.0), std::log(0.01 * density.overall()));
  EXPECT_NEAR(density.log_within(6.0 * 6.0, 0.0), std::log(density.overall()), 0.5);
}

/// A lattice of points, 3 m apart, in the plane through `origin` that `x` and `y` span.
template <int Dim>
std::vector<Point<Dim>> lattice(const Point<Dim>& origin, const Point<Dim>& x, const Point<Dim>& y) {
  std::vector<Point<Dim>> points;
  for (int i = 0; i < 8; ++i) {
    for (int k = 0; k < 8; ++k) points.push_back(origin + 3.0 * i * x + 3.0 * k * y);
  }
  return points;
}

/// The slab that is evenly filled by points with this standard deviation across is thicker by 5^(3/2) / 3 in the ratio of
/// volumes of ellipsoids and ellipses.
TEST(NeighbourDensityTest, TakesWhatLiesInAPlaneForAsThickAsItsNoise) {
  const double deviation = 0.07;
  const PointMatrix<3> noise = deviation * deviation * PointMatrix<3>::Identity();
  const std::vector<Points> flat = {lattice<2>({0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0})};
  const double thickness = std::pow(5.0, 1.5) / 3.0 * deviation;
  const Point<3> tilted(0.0, 0.8, 0.6);
  for (const double height : {0.0, 1.2}) {
    for (const Point<3>& y : {Point<3>(0.0, 1.0, 0.0), tilted}) {
      const std::vector<std::vector<Point<3>>> sets(3, lattice<3>({0.0, 0.0, height}, Point<3>::UnitX(), y));
      EXPECT_NEAR(thickness * NeighbourDensity<3>(sets, noise).overall() / NeighbourDensity<2>(flat).overall(), 1.0, 1e-3);
    }
  }
}

TEST(NeighbourDensityTest, TakesWhatLiesOnALineForAsThickAsItsNoise) {
  const std::vector<Points> row = {{{0.0, 2.0}, {3.0, 2.0}, {6.0, 2.0}, {9.0, 2.0}}};
  const double variance = 15.0;  // along the line
  const double area = 4.0 * std::numbers::pi * std::sqrt(variance) * 0.1;
  EXPECT_NEAR(NeighbourDensity<2>(row, 0.01 * PointMatrix<2>::Identity()).overall(), 4.0 / area, 1e-2);
}

TEST(NeighbourDensityTest, IsFiniteWhereNothingIsKnownOfTheThicknessOfWhatLiesOnALine) {
  const std::vector<Points> row = {{{0.0, 2.0}, {3.0, 2.0}, {6.0, 2.0}, {9.0, 2.0}}};
  EXPECT_EQ(NeighbourDensity<2>(row).overall(), 1.0);
}

TEST(NeighbourDensityTest, DoesNotDependOnNoiseThatIsSmallerThanWhatThePointsFill) {
  const std::vector<Points> sets = {kSeenTogether};
  EXPECT_EQ(NeighbourDensity<2>(sets, 0.1 * PointMatrix<2>::Identity()).overall(), NeighbourDensity<2>(sets).overall());
}

/// There are more distances than are kept, which are those of every second set.
TEST(NeighbourDensityTest, KnowsASampleOfTheDistancesOfManySets) {
  testing::Random random(7);
  Points points;
  for (int k = 0; k < 400; ++k) points.push_back(random.vector<2>(50.0));
  const std::vector<Points> many(60, points);
  const std::vector<Points> half(30, points);
  const NeighbourDensity<2> of_many(many);
  const NeighbourDensity<2> of_half(half);
  for (const double distance : {0.1, 1.0, 10.0}) {
    EXPECT_DOUBLE_EQ(of_many.log_within(distance * distance, 0.0), of_half.log_within(distance * distance, 0.0)) << distance;
  }
}

TEST(NeighbourDensityTest, IsAsManyTimesHigherAsTheOverallOne) {
  const std::vector<Points> sets = {kSeenTogether};
  const NeighbourDensity<2> seen(sets);
  NeighbourDensity<2> around(sets);
  around.set_overall(3.0 * seen.overall());
  EXPECT_DOUBLE_EQ(around.overall(), 3.0 * seen.overall());
  for (const double distance : {1.7, 3.0, 10.0}) {
    EXPECT_NEAR(around.log_within(distance * distance, 0.0), seen.log_within(distance * distance, 0.0) + std::log(3.0), 1e-12)
        << distance;
  }
}

TEST(NeighbourDensityTest, LearnsNoDistancesFromWhatIsSeenAlone) {
  std::vector<Points> sets = {kSeenTogether};
  const NeighbourDensity<2> together(sets);
  for (const auto& p : kSeenTogether) sets.push_back({p});
  const NeighbourDensity<2> and_alone(sets);
  for (const double distance : {0.5, 1.7, 3.0}) {
    EXPECT_DOUBLE_EQ(and_alone.log_within(distance * distance, 0.0), together.log_within(distance * distance, 0.0)) << distance;
  }
}

TEST(NeighbourDensityTest, FallsWithTheVolumeHoweverLargeThatIs) {
  const std::vector<std::vector<Point<3>>> sets = {{Point<3>::Zero(), Point<3>::UnitX()}};
  const NeighbourDensity<3> density(sets);
  EXPECT_NEAR(density.log_within(1e120 * 1e120, 0.0), density.log_within(1e100 * 1e100, 0.0) - 60.0 * std::log(10.0), 1e-9);
}

}  // namespace
}  // namespace mapjoin
