// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/align/joined_map.hpp>
#include <mapjoin/join/spanning_tree.hpp>
#include <mapjoin/join/study/continuation.hpp>
#include <mapjoin/localmap/check.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/demand_valid.hpp>
#include <mapjoin/model/marginal_information.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// Copies observations, and has copies of their lists point to the copies.
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
Continuation<Dim>::Continuation(JoinProblem<Dim>& join, const PartialMap<Dim>& partial, const Gauge<Dim>& gauge)
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

/// What the tree hangs by is quadratic.
template <int Dim>
void Continuation<Dim>::take_tree() {
  using Source = typename JoiningSystem<Dim>::Source;
  std::vector<std::vector<bool>> is_in_tree;  // per map and target
  for (const WeightedMap& map : maps_) is_in_tree.emplace_back(map.joined_map->poses.size() + map.joined_map->features.size());
  const auto take = [&](const auto& edge) {
    if (!edge.observation) return;
    const Source source = join_.system().source_of(edge.observation->factor);
    if (source.kind == Source::kPoseFactor) poses_[source.place].is_quadratic = true;
    if (source.kind == Source::kFeatureFactor) features_[source.place].is_quadratic = true;
    if (source.kind == Source::kMap) is_in_tree[source.place][edge.observation->target] = true;
  };
  const SpanningTree tree = spanning_tree(join_.system());
  std::ranges::for_each(tree.poses, take);
  std::ranges::for_each(tree.features, take);
  for (std::size_t m = 0; m < maps_.size(); ++m) {
    const LocalMap<Dim>& joined_map = *maps_[m].joined_map;
    std::vector<Eigen::Index> rest;
    for (std::size_t t = 0; t < is_in_tree[m].size(); ++t) {
      auto& rows = is_in_tree[m][t] ? maps_[m].tree_rows : rest;
      for (Eigen::Index row = joined_map.row(t); row < joined_map.row(t + 1); ++row) rows.push_back(row);
    }
    maps_[m].quadratic = marginal_information(joined_map.information, maps_[m].tree_rows, rest);
  }
}

template <int Dim>
void Continuation<Dim>::set_weight(double weight) {
  for (auto& o : poses_) o.weighted.information = (o.is_quadratic ? 1.0 : weight) * o.joined_map->information;
  for (auto& o : features_) o.weighted.information = (o.is_quadratic ? 1.0 : weight) * o.joined_map->information;
  for (auto& m : maps_) {
    m.weighted.information = weight * m.joined_map->information;
    m.weighted.information(m.tree_rows, m.tree_rows) += (1.0 - weight) * m.quadratic;
  }
  const bool is_whole = weight == 1.0;
  join_.system().observe(is_whole ? partial_ : weighted_partial_, is_whole ? gauge_ : weighted_gauge_);
}

template <int Dim>
int ContinuedResult<Dim>::path_iterations() const {
  return std::accumulate(path.begin(), path.end(), 0,
                         [](int sum, const PathPoint& point) { return sum + point.result.iterations; });
}

template <int Dim>
PartialMap<Dim> composed_start(const SubmapGraph<Dim>& graph, const Pose<Dim>& origin) {
  PartialMap<Dim> joined_map = joined_map_of(graph);
  joined_map.state = composed_state(graph, joined_map, origin, join_segments(graph, {Schedule::kBatch, {}, {}}));
  place_fixed_poses(graph, joined_map);
  return joined_map;
}

namespace {

/// Where a path ends, over the whole submap graph.
template <int Dim>
struct PathEnd {
  Values<Dim> state;
  std::vector<PathPoint> path;
  double seconds = 0.0;
};

template <int Dim>
PathEnd<Dim> end_of_path(const SubmapGraph<Dim>& graph, const Pose<Dim>& origin, const Values<Dim>* values,
                         const RunOptions& options, const std::stop_token& stop) {
  PathEnd<Dim> end{
      {Table<PoseIndex, Pose<Dim>>(graph.pose_count), Table<FeatureIndex, Point<Dim>>(graph.feature_count, Point<Dim>::Zero())},
      {}};
  const Stopwatch watch(end.seconds);
  PartialMap<Dim> joined_map = composed_start(graph, origin);
  set_start(options.start, options.seed, values, joined_map);
  place_fixed_poses(graph, joined_map);
  const Gauge<Dim> gauge = gauge_of(graph, joined_map);
  JoinProblem<Dim> join(joined_map, gauge, options.solver.engine);
  MinimiseOptions leading = solver_of(SolveOnTheWay::kLoosely);
  leading.method = options.solver.method;
  Continuation<Dim> continuation(join, joined_map, gauge);
  for (const double weight : {0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1}) {
    if (stop.stop_requested()) break;
    continuation.set_weight(weight);
    end.path.push_back({weight, minimise_join(join, options.state, leading, stop)});
  }
  write_values(join.estimate(), joined_map.poses, joined_map.features, end.state);
  return end;
}

/// The result of a run from there.
template <int Dim>
ContinuedResult<Dim> after(PathEnd<Dim> end, RunResult<Dim> result) {
  result.seconds.join += end.seconds;
  return {std::move(result), std::move(end.path)};
}

RunOptions from_values(RunOptions options) {
  options.schedule = Schedule::kBatch;
  options.start = Start::kFile;
  return options;
}

}  // namespace

template <int Dim>
Expected<ContinuedResult<Dim>> run_continued(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                             const RunOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto connected = check_connected(log); !connected) return tl::unexpected(connected.error());
  if (auto of_log = check_local_maps(log, split, maps); !of_log) return tl::unexpected(of_log.error());
  if (auto given = check_start(log, options.start); !given) return tl::unexpected(given.error());
  PathEnd<Dim> end = end_of_path(submap_graph_of(log, split, maps), origin_of(log), &log.initial, options, stop);
  return run_from_maps(log, split, std::move(maps), from_values(options), stop, &end.state).map([&](RunResult<Dim>&& result) {
    return after(std::move(end), std::move(result));
  });
}

template <int Dim>
Expected<ContinuedResult<Dim>> run_continued(const Log<Dim>& log, const RunOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto connected = check_connected(log); !connected) return tl::unexpected(connected.error());
  double seconds = 0.0;
  Expected<LocalMaps<Dim>> built;
  Split parts = split(log, options.split);
  const auto progress = [&](std::size_t done, std::size_t to_do) {
    if (options.progress) options.progress(Stage::kBuild, done, to_do);
  };
  {
    const Stopwatch watch(seconds);
    built = build_local_maps(log, parts, {options.solver, progress}, stop);
  }
  if (!built) return tl::unexpected(built.error());
  auto result = run_continued(log, parts, std::move(built->maps), options, stop);
  if (result) result->build_iterations = built->iterations;
  if (result) result->seconds.build = seconds;
  return result;
}

template <int Dim>
Expected<ContinuedResult<Dim>> run_continued(const SubmapSet<Dim>& set, const RunOptions& options,
                                             const std::stop_token& stop) {
  demand_valid(options);
  if (auto connected = check_connected(set); !connected) return tl::unexpected(connected.error());
  if (auto given = check_start(set, options.start); !given) return tl::unexpected(given.error());
  PathEnd<Dim> end = end_of_path<Dim>(submap_graph_of(set), {}, nullptr, options, stop);
  return run(set, from_values(options), stop, &end.state).map([&](RunResult<Dim>&& result) {
    return after(std::move(end), std::move(result));
  });
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                     \
  template class Continuation<Dim>;                                                                                  \
  template struct ContinuedResult<Dim>;                                                                              \
  template PartialMap<Dim> composed_start(const SubmapGraph<Dim>&, const Pose<Dim>&);                                \
  template Expected<ContinuedResult<Dim>> run_continued(const Log<Dim>&, const RunOptions&, const std::stop_token&); \
  template Expected<ContinuedResult<Dim>> run_continued(const Log<Dim>&, const Split&, std::vector<LocalMap<Dim>>,   \
                                                        const RunOptions&, const std::stop_token&);                  \
  template Expected<ContinuedResult<Dim>> run_continued(const SubmapSet<Dim>&, const RunOptions&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
