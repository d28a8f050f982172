// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/continuation.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/join/spanning_tree.hpp>
#include <mapjoin/model/information.hpp>

namespace mapjoin {
namespace {

/// Copies the observations of two lists into `out`, and points the lists to the copies.
template <typename Weighted, typename Observation>
void copy(std::vector<const Observation*>& own, std::vector<const Observation*>& priors, std::vector<Weighted>& out) {
  out.reserve(own.size() + priors.size());  // addresses stay
  for (auto* list : {&own, &priors}) {
    for (const Observation*& o : *list) {
      out.push_back({o, *o});
      o = &out.back().weighted;
    }
  }
}

}  // namespace

template <int Dim>
Continuation<Dim>::Continuation(JoiningSystem<Dim>& join, const PartialMap<Dim>& partial, const Gauge<Dim>& gauge)
    : join_(join), partial_(partial), gauge_(gauge), weighted_partial_(partial), weighted_gauge_(gauge) {
  copy(weighted_partial_.factors.pose_factors, weighted_gauge_.priors.pose_factors, poses_);
  copy(weighted_partial_.factors.feature_factors, weighted_gauge_.priors.feature_factors, features_);
  maps_.reserve(partial.factors.submaps.size());  // addresses stay
  for (const LocalMap<Dim>*& map : weighted_partial_.factors.submaps) {
    maps_.push_back({map, *map});
    map = &maps_.back().weighted;
  }
  take_tree();
}

/// Marks the observations and the rows of maps along the tree as quadratic.
template <int Dim>
void Continuation<Dim>::take_tree() {
  using Source = typename JoiningSystem<Dim>::Source;
  std::vector<std::vector<bool>> is_in_tree;  // per map and target
  for (const WeightedMap& map : maps_) is_in_tree.emplace_back(map.original->poses.size() + map.original->features.size());
  const auto take = [&](const auto& edge) {
    if (!edge.observation) return;
    const Source source = join_.source_of(edge.observation->factor);
    if (source.kind == Source::kPoseFactor) poses_[source.place].is_quadratic = true;
    if (source.kind == Source::kFeatureFactor) features_[source.place].is_quadratic = true;
    if (source.kind == Source::kMap) is_in_tree[source.place][edge.observation->target] = true;
  };
  const SpanningTree tree = spanning_tree(join_);
  std::ranges::for_each(tree.poses, take);
  std::ranges::for_each(tree.features, take);
  for (std::size_t m = 0; m < maps_.size(); ++m) {
    const LocalMap<Dim>& map = *maps_[m].original;
    std::vector<Eigen::Index> rest;
    for (std::size_t t = 0; t < is_in_tree[m].size(); ++t) {
      auto& rows = is_in_tree[m][t] ? maps_[m].tree_rows : rest;
      for (Eigen::Index row = map.row(t); row < map.row(t + 1); ++row) rows.push_back(row);
    }
    maps_[m].quadratic = marginal_information(map.information, maps_[m].tree_rows, rest);
  }
}

template <int Dim>
void Continuation<Dim>::set_weight(double weight) {
  for (auto& o : poses_) o.weighted.information = (o.is_quadratic ? 1.0 : weight) * o.original->information;
  for (auto& o : features_) o.weighted.information = (o.is_quadratic ? 1.0 : weight) * o.original->information;
  for (auto& m : maps_) {
    m.weighted.information = weight * m.original->information;
    m.weighted.information(m.tree_rows, m.tree_rows) += (1.0 - weight) * m.quadratic;
  }
  const bool is_whole = weight == 1.0;
  join_.observe(is_whole ? partial_ : weighted_partial_, is_whole ? gauge_ : weighted_gauge_);
}

template <int Dim>
std::vector<PathPoint> follow_path(JoiningSystem<Dim>& join, const PartialMap<Dim>& partial, const Gauge<Dim>& gauge,
                                   JoinedState state, Method method, const std::stop_token& stop) {
  MinimiseOptions leading = solver_of(SolveOnTheWay::kLoosely);
  leading.method = method;
  Continuation<Dim> continuation(join, partial, gauge);
  std::vector<PathPoint> path;
  for (const double weight : {0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1}) {
    if (stop.stop_requested()) break;
    continuation.set_weight(weight);
    path.push_back({weight, minimise_join(join, state, leading, stop)});
  }
  continuation.set_weight(1.0);
  return path;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                           \
  template class Continuation<Dim>;                                                                                        \
  template std::vector<PathPoint> follow_path(JoiningSystem<Dim>&, const PartialMap<Dim>&, const Gauge<Dim>&, JoinedState, \
                                              Method, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
