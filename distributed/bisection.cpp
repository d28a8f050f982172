// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <mapjoin/distributed/bisection.hpp>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// Halvings of an interval: as fine as its ends are kept.
constexpr int kHalvings = 50;
/// A region may have so much more or less than its share of the points.
constexpr double kSlack = 0.02;
/// Cuts that are compared within that slack.
constexpr int kCandidates = 256;

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

/// Where, from `low` to `high`, a cut across an axis makes the fewest unknowns shared.
template <int Dim>
double thinnest(const Communicator& comm, const std::vector<Span<Dim>>& spans, int axis, double low, double high) {
  const double step = (high - low) / (kCandidates - 1);
  std::vector<double> shared(kCandidates, 0.0);
  for (const Span<Dim>& span : spans) {
    const double first = std::ceil((span.box.min()[axis] - low) / step);
    const double last = std::floor((span.box.max()[axis] - low) / step);
    for (double k = std::max(first, 0.0); k <= std::min(last, kCandidates - 1.0); ++k) {
      shared[static_cast<std::size_t>(k)] += span.unknowns;
    }
  }
  comm.sum(shared);
  const auto best = std::ranges::min_element(shared) - shared.begin();
  return low + static_cast<double>(best) * step;
}

}  // namespace

template <int Dim>
Bisection<Dim>::Bisection(const Communicator& comm, std::vector<Point<Dim>> points, std::vector<Span<Dim>> spans) {
  cut(comm, std::move(points), std::move(spans), 0, static_cast<std::size_t>(comm.size()));
}

template <int Dim>
void Bisection<Dim>::cut(const Communicator& comm, std::vector<Point<Dim>> points, std::vector<Span<Dim>> spans,
                         std::size_t first, std::size_t last) {
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
  const auto at_share = [&](double s) { return quantile(comm, coordinates, s, least[axis], largest[axis]); };
  const double at = thinnest(comm, spans, axis, at_share(share * (1.0 - kSlack)), at_share(share * (1.0 + kSlack)));

  const auto above = std::partition(points.begin(), points.end(), [&](const auto& point) { return point[axis] < at; });
  std::vector<Point<Dim>> points_above(above, points.end());
  points.erase(above, points.end());
  std::vector<Span<Dim>> spans_above;
  std::ranges::copy_if(spans, std::back_inserter(spans_above), [&](const auto& span) { return span.box.max()[axis] >= at; });
  std::erase_if(spans, [&](const auto& span) { return span.box.min()[axis] >= at; });
  cut(comm, std::move(points), std::move(spans), first, middle);
  cuts_[here].axis = axis;
  cuts_[here].at = at;
  cuts_[here].above = cuts_.size();
  cut(comm, std::move(points_above), std::move(spans_above), middle, last);
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
