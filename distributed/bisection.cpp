// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <mapjoin/distributed/bisection.hpp>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// Halvings of an interval: as fine as its ends are kept.
constexpr int kHalvings = 50;

/// The least and the largest coordinate of all ranks' points.
template <int Dim>
std::pair<Point<Dim>, Point<Dim>> extent(const Communicator& comm, const std::vector<Point<Dim>>& points) {
  Point<Dim> least = Point<Dim>::Constant(std::numeric_limits<double>::max());
  Point<Dim> largest = -least;
  for (const auto& point : points) {
    least = least.cwiseMin(point);
    largest = largest.cwiseMax(point);
  }
  for (int i = 0; i < Dim; ++i) {
    least[i] = -comm.max(-least[i]);
    largest[i] = comm.max(largest[i]);
  }
  return {least, largest};
}

/// The coordinate below which `share` of all ranks' values lie.
double quantile(const Communicator& comm, const std::vector<double>& values, double share, double low, double high) {
  const auto wanted =
      static_cast<std::int64_t>(share * static_cast<double>(comm.sum(static_cast<std::int64_t>(values.size()))));
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    const auto below = std::ranges::count_if(values, [&](double value) { return value < middle; });
    (comm.sum(static_cast<std::int64_t>(below)) <= wanted ? low : high) = middle;
  }
  return low;
}

}  // namespace

template <int Dim>
Bisection<Dim>::Bisection(const Communicator& comm, std::vector<Point<Dim>> points) {
  cut(comm, std::move(points), 0, static_cast<std::size_t>(comm.size()));
}

template <int Dim>
void Bisection<Dim>::cut(const Communicator& comm, std::vector<Point<Dim>> points, std::size_t first, std::size_t last) {
  const std::size_t here = cuts_.size();
  cuts_.push_back({.first = first, .regions = last - first});
  if (last - first == 1) return;
  const auto [least, largest] = extent(comm, points);
  int axis = 0;
  (largest - least).maxCoeff(&axis);
  std::vector<double> coordinates;
  for (const auto& point : points) coordinates.push_back(point[axis]);
  const std::size_t middle = first + (last - first) / 2;
  const double share = static_cast<double>(middle - first) / static_cast<double>(last - first);
  const double at = quantile(comm, coordinates, share, least[axis], largest[axis]);
  const auto begin_above = std::partition(points.begin(), points.end(), [&](const auto& point) { return point[axis] < at; });
  std::vector<Point<Dim>> above(begin_above, points.end());
  points.erase(begin_above, points.end());
  cut(comm, std::move(points), first, middle);
  cuts_[here].axis = axis;
  cuts_[here].at = at;
  cuts_[here].above = cuts_.size();
  cut(comm, std::move(above), middle, last);
}

template <int Dim>
std::size_t Bisection<Dim>::region_of(const Point<Dim>& point) const {
  std::size_t k = 0;
  while (cuts_[k].regions > 1) k = point[cuts_[k].axis] < cuts_[k].at ? k + 1 : cuts_[k].above;
  return cuts_[k].first;
}

template class Bisection<2>;
template class Bisection<3>;

}  // namespace mapjoin::distributed
