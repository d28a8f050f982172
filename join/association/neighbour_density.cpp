// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/neighbour_density.hpp>
#include <numbers>

namespace mapjoin {
namespace {

/// The volume of a ball (disc).
template <int Dim>
double ball(double radius) {
  constexpr double kPi = std::numbers::pi;
  return Dim == 2 ? kPi * radius * radius : 4.0 / 3.0 * kPi * radius * radius * radius;
}

/// The volume of the ellipsoid that points fill evenly whose covariance is that of these: radii are √(Dim + 2) of its standard
/// deviations.
template <int Dim>
double volume(std::span<const Point<Dim>> points) {
  Point<Dim> mean = Point<Dim>::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  PointMatrix<Dim> covariance = PointMatrix<Dim>::Zero();
  for (const auto& p : points) covariance += (p - mean) * (p - mean).transpose();
  covariance /= static_cast<double>(points.size() - 1);
  return ball<Dim>(std::sqrt(Dim + 2.0)) * std::sqrt(std::max(0.0, covariance.determinant()));
}

/// Points over the volume that they fill: of every set that fills any, else of all sets laid over each other.
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
  const double within = 2.0 * (static_cast<double>(pairs) + 1.0) / (points_ * ball<Dim>(distance));
  return std::log(std::min(within, overall_));
}

template class NeighbourDensity<2>;
template class NeighbourDensity<3>;

}  // namespace mapjoin
