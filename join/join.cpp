// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/free_to_move.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
std::vector<MapFit> map_fits(const JoiningSystem<Dim>& system) {
  std::vector<MapFit> fits(system.maps().size());
  parallel_for(fits.size(), [&](std::size_t m) {
    const auto& placed = system.maps()[m];
    const LocalMap<Dim>& map = *placed.map;
    const PoseIndex end = map.poses.empty() ? map.base : map.poses.back();
    fits[m] = {map.base, end, system.map_chi2(placed, system.estimate()), information_rank(map.information)};
  });
  return fits;
}

template <int Dim>
std::int64_t measured_rows(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge, const std::vector<MapFit>& maps) {
  double rows = 0.0;
  for (const MapFit& map : maps) rows += static_cast<double>(map.rows);
  const auto add = [&](const auto& observations) {
    rows += parallel_sum(observations.size(), kObservationsPerPiece,
                         [&](std::size_t k) { return static_cast<double>(information_rank(observations[k]->information)); });
  };
  for (const auto* selection : {&partial.factors, &gauge.priors}) {
    add(selection->pose_factors);
    add(selection->feature_factors);
  }
  return static_cast<std::int64_t>(rows);
}

/// The state of the whole submap graph from the estimate of its joined part.
template <int Dim>
Values<Dim> state_of(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& joined_map, const Values<Dim>& estimate) {
  Values<Dim> state;
  state.poses.resize(graph.pose_count);
  state.features.resize(graph.feature_count, Point<Dim>::Zero());
  write_values(estimate, joined_map.poses, joined_map.features, state);
  for (const auto& marginalised : graph.maps) recover_local_features(marginalised, state);
  return state;
}

/// The arguments of join().
template <int Dim>
struct Task {
  const SubmapGraph<Dim>& graph;
  const PoseIds& pose_ids;
  const FeatureIds& feature_ids;
  const JoinOptions<Dim>& options;
  const std::stop_token& stop;
};

/// Bad input, with their names, if the observations leave variables free to move.
template <int Dim>
Expected<void> check_determined(const Task<Dim>& task, const PartialMap<Dim>& joined_map, const Join<Dim>& join,
                                JoiningSystem<Dim>& system) {
  const MinimiseResult& result = join.result;
  Freedom freedom;
  if (result.singular) {
    freedom = freedom_at(*result.singular, system);
  } else if (result.factorisations > 0 && std::isfinite(result.chi2) && !is_surely_determined(system, join.maps)) {
    freedom = hidden_freedom(system);
  }
  if (!freedom.is_any()) return {};
  return bad_input(free_to_move(system, freedom, names_at(joined_map.poses, task.pose_ids),
                                names_at(joined_map.features, task.feature_ids)));
}

/// The last solve of the joined map, starting at the estimate of `system`.
template <int Dim>
Expected<Join<Dim>> solved(const Task<Dim>& task, PartialMap<Dim> joined_map, const Gauge<Dim>& gauge,
                           JoiningSystem<Dim> system, const MinimiseOptions& solver) {
  Join<Dim> join;
  const Values<Dim> start = system.estimate();
  join.result = {minimise_join(system, task.options.state, solver, task.stop)};
  join.result.largest_rotation = largest_rotation_update(start, system.estimate());
  if (join.result.status == MinimiseStatus::kInterrupted) return interrupted("joining");
  join.maps = map_fits(system);
  if (auto determined = check_determined(task, joined_map, join, system); !determined) {
    return tl::unexpected(determined.error());
  }
  join.state = state_of(task.graph, joined_map, system.estimate());
  for (const PoseIndex place : gauge.anchored) join.anchored.push_back(joined_map.poses[place]);
  join.result.dof = measured_rows(joined_map, gauge, join.maps) - static_cast<std::int64_t>(system.equations().size());
  join.poses = std::move(joined_map.poses);
  join.features = std::move(joined_map.features);
  join.system = std::make_unique<JoiningSystem<Dim>>(std::move(system));
  return join;
}

/// Joins by one schedule, not kAuto.
template <int Dim>
Expected<Join<Dim>> join_by(Schedule schedule, const Task<Dim>& task, const MinimiseOptions& solver) {
  const auto& [graph, pose_ids, feature_ids, options, stop] = task;
  const ScheduleOptions on_the_way{schedule, options.state, options.progress};
  PartialMap<Dim> joined_map = joined_map_of(graph);
  const Gauge<Dim> gauge = gauge_of(graph, joined_map);
  JoinedPartialMaps<Dim> partials;
  std::optional<JoiningSystem<Dim>> system;  // its pattern, ordering and symbolic factor need no state
  parallel_invoke([&] { partials = join_segments(task.graph, on_the_way, task.stop); },
                  [&] {
                    if (!task.stop.stop_requested()) system.emplace(joined_map, gauge, solver.engine);
                  });
  if (stop.stop_requested()) return interrupted("joining");

  joined_map.state = composed_state(graph, joined_map, options.origin, std::move(partials));
  set_start(options.start, options.seed, options.values, joined_map);
  place_fixed_poses(graph, joined_map);
  system->estimate() = joined_map.state;
  std::vector<PathPoint> path;
  if (options.gradual) path = follow_path(*system, joined_map, gauge, options.state, solver.method, stop);
  return solved(task, std::move(joined_map), gauge, *std::move(system), solver).map([&](Join<Dim> join) {
    join.result.schedule = schedule;
    join.path = std::move(path);
    return join;
  });
}

/// Continues a join that stopped at its limit of iterations.
template <int Dim>
Expected<Join<Dim>> continued(const Task<Dim>& task, Join<Dim> join, const MinimiseOptions& solver) {
  PartialMap<Dim> joined_map = joined_map_of(task.graph);
  const Gauge<Dim> gauge = gauge_of(task.graph, joined_map);
  auto further = solved(task, std::move(joined_map), gauge, std::move(*join.system), solver);
  if (!further) return further;
  JoinResult result = std::move(join.result);
  result.append(further->result);
  result.largest_rotation = std::max(result.largest_rotation, further->result.largest_rotation);
  further->result = std::move(result);
  return further;
}

/// Number of iterations after which a schedule that has not converged is set aside; it goes on only if no other does better.
constexpr int kTrialIterations = 75;

template <int Dim>
Expected<Join<Dim>> join_by_best(const Task<Dim>& task) {
  MinimiseOptions trial = task.options.solver;
  trial.max_iterations = std::min(trial.max_iterations, kTrialIterations);
  auto best = best_of_ways<Join<Dim>>([&](Schedule way) { return join_by(way, task, trial); }, &Join<Dim>::result);
  if (task.stop.stop_requested()) return interrupted("joining");
  if (!best) return best;
  if (best->result.status != MinimiseStatus::kMaxIterations) return best;
  MinimiseOptions rest = task.options.solver;
  rest.max_iterations -= trial.max_iterations;
  return rest.max_iterations > 0 ? continued(task, *std::move(best), rest) : std::move(best);
}

}  // namespace

double MapFit::probability() const {
  return chi_squared_upper_tail(chi2, static_cast<double>(rows));
}

template <int Dim>
Expected<Join<Dim>> join(const SubmapGraph<Dim>& graph, const PoseIds& pose_ids, const FeatureIds& feature_ids,
                         const JoinOptions<Dim>& options, const std::stop_token& stop) {
  const Task<Dim> task{graph, pose_ids, feature_ids, options, stop};
  return options.schedule == Schedule::kAuto ? join_by_best(task) : join_by(options.schedule, task, options.solver);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                         \
  template Expected<Join<Dim>> join(const SubmapGraph<Dim>&, const PoseIds&, const FeatureIds&, const JoinOptions<Dim>&, \
                                    const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
