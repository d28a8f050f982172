// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <limits>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/robust/selection.hpp>
#include <set>
#include <utility>

namespace mapjoin {
namespace {

constexpr Vertex kWorldVertex = 0;

Vertex vertex(PoseIndex pose) {
  return pose == kWorld ? kWorldVertex : static_cast<Vertex>(1 + pose.value);
}

/// The edges between poses and features of a log besides closures; the vertices are the World, then poses, then features.
template <int Dim>
std::vector<Edge> ties_without_closures(const Log<Dim>& log) {
  std::vector<Edge> edges;
  for (const auto& o : log.odometry()) edges.emplace_back(vertex(o.base), vertex(o.target));
  for (const auto& o : log.pose_priors()) edges.emplace_back(vertex(o.base), vertex(o.target));
  for (const auto& o : log.graph.feature_factors) {
    edges.emplace_back(vertex(o.base), static_cast<Vertex>(1 + log.poses.size()) + static_cast<Vertex>(o.target.value));
  }
  for (const auto& fixed : log.graph.fixed) edges.emplace_back(kWorldVertex, vertex(fixed.pose));
  return edges;
}

/// The sessions that a closure connects.
using Sessions = std::pair<std::uint32_t, std::uint32_t>;
template <int Dim>
Sessions sessions_of(const Log<Dim>& log, const PoseFactor<Dim>& closure) {
  return std::minmax(log.poses[closure.base].session, log.poses[closure.target].session);
}

}  // namespace

template <int Dim>
Log<Dim> selected(const Log<Dim>& log, const std::vector<std::size_t>& closures, const std::vector<bool>& observations) {
  Log<Dim> some = log;
  if (!observations.empty()) {
    auto& factors = some.graph.feature_factors;
    factors.clear();
    for (std::size_t k = 0; k < log.graph.feature_factors.size(); ++k) {
      if (k >= observations.size() || observations[k]) factors.push_back(log.graph.feature_factors[k]);
    }
  }
  auto& factors = some.graph.pose_factors;
  factors.assign(log.odometry().begin(), log.odometry().end());
  for (const std::size_t k : closures) factors.push_back(log.closures()[k]);
  factors.insert(factors.end(), log.pose_priors().begin(), log.pose_priors().end());
  return some;
}

template <int Dim>
std::vector<std::size_t> tied_together(const Log<Dim>& log, const std::vector<double>& odds, std::vector<bool> is_chosen) {
  std::vector<std::size_t> closures(is_chosen.size());  // the chosen ones, then the others, the likeliest first
  for (std::size_t k = 0; k < closures.size(); ++k) closures[k] = k;
  std::ranges::stable_sort(closures, std::greater<>(),
                           [&](std::size_t k) { return std::pair<bool, double>(is_chosen[k], odds[k]); });
  std::vector<Edge> edges = ties_without_closures(log);
  const std::size_t first = edges.size();
  for (const std::size_t k : closures) edges.emplace_back(vertex(log.closures()[k].base), vertex(log.closures()[k].target));
  const std::size_t vertices = 1 + log.poses.size() + log.features.size();
  std::set<Sessions> met;  // sessions connected only by robots that see each other
  for (const Reached& reached : spanning_forest(vertices, edges, {vertex(0), kWorldVertex})) {
    if (!reached.edge || *reached.edge < first) continue;
    const std::size_t k = closures[*reached.edge - first];
    if (is_chosen[k]) continue;
    is_chosen[k] = true;
    if (!measures_rotation(log.closures()[k])) met.insert(sessions_of(log, log.closures()[k]));
  }
  for (std::size_t k = 0; k < is_chosen.size(); ++k) {
    const PoseFactor<Dim>& closure = log.closures()[k];
    if (!measures_rotation(closure) && met.contains(sessions_of(log, closure))) is_chosen[k] = true;
  }
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < is_chosen.size(); ++k) {
    if (is_chosen[k]) chosen.push_back(k);
  }
  return chosen;
}

template <int Dim>
void keep_one_of_each_feature(const Log<Dim>& log, const std::vector<double>& against, std::vector<bool>& observations) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  Table<FeatureIndex, std::size_t> best(log.features.size(), kNone);
  const auto weight = [&](std::size_t o) { return std::pair<bool, double>(!observations[o], against[o]); };
  for (std::size_t k = 0; k < against.size(); ++k) {
    std::size_t& of_feature = best[log.observations()[k].target];
    if (of_feature == kNone || weight(k) < weight(of_feature)) of_feature = k;
  }
  for (const std::size_t k : best) {
    if (k != kNone) observations[k] = true;
  }
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                   \
  template Log<Dim> selected(const Log<Dim>&, const std::vector<std::size_t>&, const std::vector<bool>&);          \
  template std::vector<std::size_t> tied_together(const Log<Dim>&, const std::vector<double>&, std::vector<bool>); \
  template void keep_one_of_each_feature(const Log<Dim>&, const std::vector<double>&, std::vector<bool>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
