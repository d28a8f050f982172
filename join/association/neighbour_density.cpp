// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/neighbour_density.hpp>
#include <numbers>

namespace mapjoin {
namespace {

/// The volume of the ball (disc) of radius 1.
template <int Dim>
constexpr double kUnitBall = (Dim == 2 ? 1.0 : 4.0 / 3.0) * std::numbers::pi;

/// The volume of the evenly filled ellipsoid with the covariance of the points: its radii are √(Dim + 2) standard deviations.
template <int Dim>
double volume(std::span<const Point<Dim>> points) {
  Point<Dim> mean = Point<Dim>::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  PointMatrix<Dim> covariance = PointMatrix<Dim>::Zero();
  for (const auto& p : points) covariance += (p - mean) * (p - mean).transpose();
  covariance /= static_cast<double>(points.size() - 1);
  return kUnitBall<Dim> * std::pow(Dim + 2.0, 0.5 * Dim) * std::sqrt(std::max(0.0, covariance.determinant()));
}

/// The number of points over the volume that they fill: over all sets that are large enough, otherwise over all sets laid over
/// each other.
template <int Dim>
double mean_density(std::span<const std::vector<Point<Dim>>> sets) {
  constexpr std::size_t kFewest = Dim + 2;
  double points = 0.0;
  double filled = 0.0;
  std::vector<Point<Dim>> all;
  for (const auto& set : sets) {
    all.insert(all.end(), set.begin(), set.end());
    if (set.size() < kFewest) continue;
    points += static_cast<double>(set.size());
    filled += volume<Dim>(set);
  }
  if (filled > 0.0) return points / filled;
  if (all.size() < kFewest) return 1.0;
  return static_cast<double>(all.size()) / static_cast<double>(sets.size()) / volume<Dim>(all);
}

}  // namespace

template <int Dim>
NeighbourDensity<Dim>::NeighbourDensity(std::span<const std::vector<Point<Dim>>> sets) : overall_(mean_density<Dim>(sets)) {
  for (const auto& set : sets) {
    points_ += static_cast<double>(set.size());
    for (std::size_t i = 0; i < set.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) distances_.push_back((set[i] - set[j]).norm());
    }
  }
  std::ranges::sort(distances_);
}

template <int Dim>
double NeighbourDensity<Dim>::log_within(double distance) const {
  const auto pairs = std::ranges::upper_bound(distances_, distance) - distances_.begin();
  // Logarithms, as the volume may overflow if the distance is not known at all.
  const double log_ball = std::log(kUnitBall<Dim>) + Dim * std::log(distance);
  const double log_count = std::log(2.0 * (static_cast<double>(pairs) + 1.0) / points_);
  return std::min(log_count - log_ball, std::log(overall_));
}

template class NeighbourDensity<2>;
template class NeighbourDensity<3>;

}  // namespace mapjoin
