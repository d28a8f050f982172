// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mapjoin/localmap/seen_features.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {
namespace {

/// The number of segments looked at per candidate and session, spread over the session.
constexpr int kSamples = 64;

/// The cost of assembling and factorising a dense block of `m` scalar variables once.
double block_cost(double m) {
  return 30.0 * m * m + 0.4 * m * m * m;
}

/// The numbers of times that a join, and that the building and polishing of a map, do the work counted here once.
constexpr double kJoining = 4.0;
constexpr double kPolishing = 5.0;

/// The share of the cost that longer segments have to save: if few of them would be maps, single steps are joined.
constexpr double kAlike = 0.01;

/// The cost of one segment as a map or, if it would keep most of its poses, as a raw segment of one-step maps.
template <int Dim>
double segment_cost(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, const Segment& segment, SeenFeatures& seen) {
  constexpr double kDof = kPoseDof<Dim>;
  const double steps = segment.end - segment.begin;
  const auto observations = observations_of(log, segment);
  const auto referenced =
      static_cast<double>(std::count(kept.begin() + segment.begin.value + 1, kept.begin() + segment.end.value, true));
  if (steps < 2.0 || 2.0 * referenced > steps - 1.0) {
    double blocks = 0.0;
    for (PoseIndex pose = segment.begin; pose < segment.end; ++pose) {
      blocks += block_cost(2.0 * kDof + Dim * static_cast<double>(observations_of(log, {pose, pose + 1}).size()));
    }
    return kJoining * blocks;
  }
  const double m = (2.0 + referenced) * kDof + Dim * static_cast<double>(seen.count_new(observations, segment.begin));
  return kJoining * block_cost(m) + kPolishing * (2.0 * steps * kDof * m * m + 0.5 * m * m * m);
}

}  // namespace

template <int Dim>
double cost_per_step(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, int poses_per_map) {
  SeenFeatures seen(log.features.size());
  double cost = 0.0;
  double steps = 0.0;
  for (const Session& session : log.sessions) {
    const int available = (session.end - 1 - session.begin) / poses_per_map;
    const int stride = std::max(1, (available + kSamples - 1) / kSamples) * poses_per_map;
    for (PoseIndex begin = session.begin; begin + poses_per_map < session.end; begin += stride) {
      cost += segment_cost(log, kept, {begin, begin + poses_per_map}, seen);
      steps += poses_per_map;
    }
  }
  return steps > 0.0 ? cost / steps : std::numeric_limits<double>::infinity();
}

template <int Dim>
int cheapest_poses_per_map(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, double fewest) {
  constexpr std::array<int, 12> kCandidates{1, 2, 3, 5, 7, 10, 15, 20, 30, 45, 70, 100};
  std::array<double, kCandidates.size()> costs{};
  parallel_for(costs.size(), [&](std::size_t k) {
    costs[k] = kCandidates[k] < fewest ? std::numeric_limits<double>::infinity() : cost_per_step(log, kept, kCandidates[k]);
  });
  const double most = (1.0 + kAlike) * *std::min_element(costs.begin(), costs.end());
  const auto least = std::find_if(costs.begin(), costs.end(), [&](double cost) { return cost <= most; });
  return std::isfinite(*least) ? kCandidates[static_cast<std::size_t>(least - costs.begin())] : kCandidates.back();
}

#define MAPJOIN_INSTANTIATE(Dim)                                                      \
  template double cost_per_step(const Log<Dim>&, const Table<PoseIndex, bool>&, int); \
  template int cheapest_poses_per_map(const Log<Dim>&, const Table<PoseIndex, bool>&, double);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
