// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/localmap/segment.hpp>
#include <mapjoin/localmap/split_cost.hpp>

namespace mapjoin {
namespace {

/// Stretches looked at per candidate, spread over the log.
constexpr Index kSamples = 64;

/// The size of the border of a map from `begin` to `end`.
template <int Dim>
double border_size(const Log<Dim>& log, const std::vector<bool>& kept, Index begin, Index end) {
  std::vector<Index> features;
  for (const auto& observation : observations_of(log, {begin, end})) features.push_back(observation.target);
  std::sort(features.begin(), features.end());
  const auto count = std::unique(features.begin(), features.end()) - features.begin();
  const auto mentioned = std::count(kept.begin() + begin + 1, kept.begin() + end, true);
  return static_cast<double>((2 + mentioned) * kPoseDof<Dim> + count * Dim);
}

}  // namespace

template <int Dim>
double cost_per_step(const Log<Dim>& log, const std::vector<bool>& kept, Index poses_per_map) {
  const double stretches = std::max(1.0, static_cast<double>(log.poses.size()) / poses_per_map);
  const double levels = 1.0 + std::log2(stretches);
  double cost = 0.0;
  double steps = 0.0;
  for (const Session& session : log.sessions) {
    const Index available = (session.end - 1 - session.begin) / poses_per_map;
    const Index stride = std::max<Index>(1, available / kSamples) * poses_per_map;
    for (Index begin = session.begin; begin + poses_per_map < session.end; begin += stride) {
      const double m = border_size(log, kept, begin, begin + poses_per_map);
      cost += levels * (30.0 * m * m + 0.4 * m * m * m) + 2.0 * poses_per_map * kPoseDof<Dim> * m * m + 0.5 * m * m * m;
      steps += poses_per_map;
    }
  }
  return steps > 0.0 ? cost / steps : std::numeric_limits<double>::infinity();
}

template <int Dim>
Index cheapest_poses_per_map(const Log<Dim>& log, const std::vector<bool>& kept) {
  Index cheapest = 1;
  double least = std::numeric_limits<double>::infinity();
  for (const Index candidate : {1, 2, 3, 5, 7, 10, 15, 20, 30, 45, 70, 100}) {
    const double cost = cost_per_step(log, kept, candidate);
    if (!(cost < least)) continue;
    least = cost;
    cheapest = candidate;
  }
  return cheapest;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                   \
  template double cost_per_step(const Log<Dim>&, const std::vector<bool>&, Index); \
  template Index cheapest_poses_per_map(const Log<Dim>&, const std::vector<bool>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
