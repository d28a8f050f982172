// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <limits>
#include <mapjoin/check/ties.hpp>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/robust/selection.hpp>
#include <mapjoin/model/information.hpp>
#include <set>
#include <utility>

namespace mapjoin {
namespace {

/// The edges between poses and features of a log: first all but closures, then these in the order given, then the odometry that
/// leaves a direction free, which ties nothing that a closure can tie. The vertices are TieVertices.
struct OrderedTies {
  std::vector<Edge> edges;
  std::size_t first_closure = 0;
  std::size_t first_weak = 0;

  bool is_closure(std::size_t edge) const { return first_closure <= edge && edge < first_weak; }
};
template <int Dim>
OrderedTies ordered_ties(const Log<Dim>& log, const std::vector<std::size_t>& closures) {
  const TieVertices of = vertices_of(log);
  OrderedTies ties;
  const auto tie = [&](std::size_t a, std::size_t b) {
    ties.edges.emplace_back(static_cast<Vertex>(a), static_cast<Vertex>(b));
  };
  std::vector<const PoseFactor<Dim>*> weak;
  for (const auto& o : log.odometry()) {
    if (information_rank(o.information) == kPoseDof<Dim>) {
      tie(of.pose(o.base), of.pose(o.target));
    } else {
      weak.push_back(&o);
    }
  }
  for (const auto& o : log.pose_priors()) tie(of.pose(o.base), of.pose(o.target));
  for (const auto& o : log.graph.feature_factors) tie(of.pose(o.base), of.feature(o.target));
  for (const auto& fixed : log.graph.fixed) tie(TieVertices::kWorldVertex, of.pose(fixed.pose));
  ties.first_closure = ties.edges.size();
  for (const std::size_t k : closures) tie(of.pose(log.closures()[k].base), of.pose(log.closures()[k].target));
  ties.first_weak = ties.edges.size();
  for (const auto* o : weak) tie(of.pose(o->base), of.pose(o->target));
  return ties;
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
  const OrderedTies ties = ordered_ties(log, closures);
  std::set<Sessions> met;  // sessions connected only by robots that see each other
  const auto first_pose = static_cast<Vertex>(vertices_of(log).pose(0));
  for (const Reached& reached : spanning_forest(vertices_of(log).size(), ties.edges, {first_pose, TieVertices::kWorldVertex})) {
    if (!reached.edge || !ties.is_closure(*reached.edge)) continue;
    const std::size_t k = closures[*reached.edge - ties.first_closure];
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
