// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <mapjoin/join/association/matching/neighbour_density.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <numbers>

namespace mapjoin {
namespace {

/// The volume of the ball (disc) of radius 1.
template <int Dim>
constexpr double kUnitBall = (Dim == 2 ? 1.0 : 4.0 / 3.0) * std::numbers::pi;

/// The fewest points of a set whose covariance tells how much they fill.
template <int Dim>
constexpr std::size_t kFewestPoints = Dim + 2;

/// The most distances that are kept; of more, those of sets spread evenly over all.
constexpr std::size_t kMostDistances = 4'000'000;

/// Number of balls that stand for a normal distribution.
constexpr int kBalls = 8;

/// The squared radii of evenly filled balls whose mixture is a normal distribution about zero with a mean square of 1: over the
/// variance along an axis they are chi-square with Dim + 2 degrees of freedom. These are quantiles in equal steps.
template <int Dim>
std::array<double, kBalls> squared_radii() {
  std::array<double, kBalls> found{};
  double p = 0.5 / kBalls;
  for (double& squared_radius : found) {
    squared_radius = chi_squared_quantile(p, Dim + 2) / Dim;
    p += 1.0 / kBalls;
  }
  return found;
}

/// The covariance of points.
template <int Dim>
PointMatrix<Dim> scatter(std::span<const Point<Dim>> points) {
  Point<Dim> mean = Point<Dim>::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  PointMatrix<Dim> covariance = PointMatrix<Dim>::Zero();
  for (const auto& p : points) covariance += (p - mean) * (p - mean).transpose();
  return covariance / static_cast<double>(points.size() - 1);
}

/// The volume of the evenly filled ellipsoid with a covariance: its radii are √(Dim + 2) standard deviations.
template <int Dim>
double volume(const PointMatrix<Dim>& covariance) {
  return kUnitBall<Dim> * std::pow(Dim + 2.0, 0.5 * Dim) * std::sqrt(std::max(0.0, covariance.determinant()));
}

/// The volume that the sets of kFewestPoints points or more fill. Where sets are thinner than `noise`, which then more than
/// doubles the determinants of their covariances, they are taken with it: what lies in a plane, or on a line, is as thick as
/// it.
template <int Dim>
double filled_by(std::span<const std::vector<Point<Dim>>> sets, const PointMatrix<Dim>& noise) {
  double filled = 0.0;
  double with_noise = 0.0;
  for (const auto& set : sets) {
    if (set.size() < kFewestPoints<Dim>) continue;
    const PointMatrix<Dim> covariance = scatter<Dim>(set);
    filled += volume<Dim>(covariance);
    with_noise += volume<Dim>(covariance + noise);
  }
  return with_noise > std::numbers::sqrt2 * filled ? with_noise : filled;
}

}  // namespace

template <int Dim>
std::optional<double> mean_density(std::span<const std::vector<Point<Dim>>> sets, const PointMatrix<Dim>& noise) {
  double points = 0.0;
  std::vector<Point<Dim>> all;
  for (const auto& set : sets) {
    all.insert(all.end(), set.begin(), set.end());
    if (set.size() >= kFewestPoints<Dim>) points += static_cast<double>(set.size());
  }
  const bool has_large_sets = points > 0.0;
  if (!has_large_sets) points = static_cast<double>(all.size()) / static_cast<double>(sets.size());
  const double filled = has_large_sets ? filled_by<Dim>(sets, noise) : filled_by<Dim>(std::span(&all, 1), noise);
  return filled > 0.0 ? std::optional(points / filled) : std::nullopt;
}

template <int Dim>
NeighbourDensity<Dim>::NeighbourDensity(std::span<const std::vector<Point<Dim>>> sets, const PointMatrix<Dim>& noise)
    : overall_(mean_density<Dim>(sets, noise).value_or(1.0)) {
  std::size_t pairs = 0;
  for (const auto& set : sets) pairs += set.size() * (set.size() - 1) / 2;
  for (std::size_t k = 0; k < sets.size(); k += 1 + pairs / kMostDistances) {
    const auto& set = sets[k];
    if (set.size() > 1) points_ += static_cast<double>(set.size());
    for (std::size_t i = 0; i < set.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) distances_.push_back((set[i] - set[j]).norm());
    }
  }
  std::ranges::sort(distances_);
}

template <int Dim>
void NeighbourDensity<Dim>::set_overall(double overall) {
  share_ *= overall_ / overall;
  overall_ = overall;
}

template <int Dim>
double NeighbourDensity<Dim>::confusable_per_deviation() const {
  return std::pow(2.0 * std::numbers::pi, 0.5 * Dim) * overall_;
}

template <int Dim>
double NeighbourDensity<Dim>::log_within(double squared_distance, double variance) const {
  static const std::array<double, kBalls> balls = squared_radii<Dim>();
  const double mean_square = squared_distance + Dim * variance;
  // Logarithms, as the volume may overflow if the distance is not known at all.
  const double log_ball = std::log(kUnitBall<Dim>) + 0.5 * Dim * std::log(mean_square);
  const double most = overall_ * std::exp(log_ball);
  double sum = 0.0;
  for (const double squared_radius : balls) {
    const auto pairs = std::ranges::upper_bound(distances_, std::sqrt(squared_radius * mean_square)) - distances_.begin();
    const double others = 2.0 * (static_cast<double>(pairs) + 1.0) / (share_ * points_);
    sum += std::min(others / std::pow(squared_radius, 0.5 * Dim), most);
  }
  return std::log(sum / kBalls) - log_ball;
}

template std::optional<double> mean_density<2>(std::span<const std::vector<Point<2>>>, const PointMatrix<2>&);
template std::optional<double> mean_density<3>(std::span<const std::vector<Point<3>>>, const PointMatrix<3>&);
template class NeighbourDensity<2>;
template class NeighbourDensity<3>;

}  // namespace mapjoin
