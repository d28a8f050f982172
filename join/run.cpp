// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/assess.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/recover.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/segment.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// The error, with the source of the data named if they are bad input.
Error of_source(const std::string& source, Error error) {
  if (error.kind == ErrorKind::kBadInput) error.message = source + ": " + error.message;
  return error;
}

template <int Dim, template <int> typename Source>
void fill_map(const Source<Dim>& source, Values<Dim> state, const std::vector<PoseIndex>& anchored, RunResult<Dim>& result) {
  result.map.pose_ids = source.poses;
  result.map.feature_ids = source.features;
  result.map.poses = std::move(state.poses);
  result.map.features = std::move(state.features);
  result.map.gauge = anchored;
  result.map.conventions = source.conventions;
  take_off_turns(result.map);
}

template <int Dim>
std::vector<SegmentView<Dim>> segments_of(const Log<Dim>& log, const Split& split) {
  const auto maps = map_segments(split.segments);
  std::vector<SegmentView<Dim>> segments(maps.size());
  parallel_for(maps.size(), [&](std::size_t k) { segments[k] = segment_view(log, split, *maps[k]); });
  return segments;
}

template <int Dim>
void count_maps(const std::vector<LocalMap<Dim>>& maps, RunFigures& figures) {
  figures.local_maps = maps.size();
  for (const auto& map : maps) figures.joint_bytes += static_cast<std::int64_t>(sizeof(double)) * map.information.size();
}

/// Copies the figures of a join.
template <int Dim>
void take_figures(const Join<Dim>& join, RunFigures& figures) {
  figures.join = join.result;
  figures.path = join.path;
  figures.maps = join.maps;
  figures.joint_bytes += join.system->equations().factor_bytes();
}

/// Joins the submap graph of a log or a set.
template <int Dim, template <int> typename Source>
Expected<Join<Dim>> join_maps(const Source<Dim>& source, const SubmapGraph<Dim>& graph, const Pose<Dim>& origin,
                              const Values<Dim>* values, const RunOptions& options, const std::stop_token& stop,
                              RunResult<Dim>& result) {
  const Stopwatch watch(result.seconds.join);
  const JoinOptions<Dim> joining{options, origin, values, options.progress_of(Stage::kJoin)};
  auto joined = join(graph, source.poses, source.features, joining, stop);
  if (!joined) return tl::unexpected(of_source(source.source, joined.error()));
  take_figures(*joined, result);
  return joined;
}

/// Recovers the variables that the local maps eliminated, into `state`.
template <int Dim>
void recover(const Log<Dim>& log, const Split& split, const SubmapGraph<Dim>& graph, const RunOptions& options,
             const std::stop_token& stop, Values<Dim>& state, RunResult<Dim>& result) {
  const Stopwatch watch(result.seconds.recover);
  if (options.progress) options.progress(Stage::kRecover, 0, 1);
  result.unrecovered = recover_interiors(log, split, graph.is_local, options.solver, state, stop);
  result.recovered_chi2 = result.chi2 = log_chi2(log, state).total();
  if (options.keep_recovered) result.recovered = state;
}

/// Minimises chi2 over every observation of the log, from the recovered estimate `state`, which takes the result.
template <int Dim>
void refine(const Log<Dim>& log, Restored<Dim>& restored, const RunOptions& options, const std::stop_token& stop,
            Values<Dim>& state, RunResult<Dim>& result) {
  if (options.progress) options.progress(Stage::kPolish, 0, 1);
  MinimiseOptions solver = options.solver;
  solver.relative_chi2 *= kRefiningShare;
  result.polish = minimise(restored.system, solver, stop);
  write_values(restored.system.estimate(), restored.joined_map.poses, restored.joined_map.features, state);
  result.chi2 = log_chi2(log, state).total();
}

/// Joins local maps, recovers the variables that they eliminated, and refines the whole.
template <int Dim>
Expected<Found<Dim>> join_and_refine(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                     const RunOptions& options, const std::stop_token& stop, RunResult<Dim> result = {}) {
  count_maps(maps, result);
  result.raw_segments = split.segments.size() - maps.size();
  result.poses_per_map = split.poses_per_map;
  const SubmapGraph<Dim> graph = submap_graph_of(log, split, std::move(maps));
  const Pose<Dim> origin = log.initial.poses.empty() ? Pose<Dim>{} : log.initial.poses.front();
  auto joined = join_maps(log, graph, origin, &log.initial, options, stop, result);
  if (!joined) return tl::unexpected(joined.error());
  // A join of the whole log has counted its rows already.
  result.dof = result.local_maps > 0 ? degrees_of_freedom(log, joined->anchored.size()) : joined->result.dof;
  Values<Dim> state = std::move(joined->state);
  recover(log, split, graph, options, stop, state, result);

  std::optional<Restored<Dim>> restored_join;
  const bool is_refined = options.polish && result.local_maps > 0;  // otherwise the join was of the whole log
  if (is_refined || wants_assessment(options)) {
    const Stopwatch watch(is_refined ? result.seconds.polish : result.seconds.covariances);
    restored_join.emplace(restored(graph, segments_of(log, split), *joined, state, options.solver.engine));
    joined->system.reset();
    if (is_refined) refine(log, *restored_join, options, stop, state, result);
  }
  if (stop.stop_requested()) return interrupted("polishing");
  fill_map(log, std::move(state), joined->anchored, result);
  result.map.stamps_ns = log.stamps_ns;
  return check_finite(result, log.source).map([&] { return Found<Dim>{std::move(result), std::move(restored_join)}; });
}

template <int Dim>
Expected<Found<Dim>> run_once(const Log<Dim>& log, const RunOptions& options, const std::stop_token& stop) {
  RunResult<Dim> result;
  Split parts;
  LocalMaps<Dim> built;
  {
    const Stopwatch watch(result.seconds.build);
    parts = split(log, options.split);
    auto maps = build_local_maps(log, parts, {options.solver, options.progress_of(Stage::kBuild)}, stop);
    if (!maps) return tl::unexpected(maps.error());
    built = std::move(*maps);
  }
  result.build_iterations = built.iterations;
  return join_and_refine(log, parts, std::move(built.maps), options, stop, std::move(result));
}

/// Joins the maps of a set, which are moved out of it.
template <int Dim>
Expected<Found<Dim>> join_set(SubmapSet<Dim>& set, const RunOptions& options, const std::stop_token& stop) {
  RunResult<Dim> result;
  count_maps(set.graph.submaps, result);
  const SubmapGraph<Dim> graph = submap_graph_of(set, std::move(set.graph.submaps));
  auto joined = join_maps<Dim>(set, graph, {}, nullptr, options, stop, result);
  if (!joined) return tl::unexpected(joined.error());
  result.dof = joined->result.dof;
  result.chi2 = joined->result.chi2;
  std::optional<Restored<Dim>> restored_join;
  if (wants_assessment(options)) restored_join.emplace(restored(graph, {}, *joined, joined->state, options.solver.engine));
  fill_map(set, std::move(joined->state), joined->anchored, result);
  return check_finite(result, set.source).map([&] { return Found<Dim>{std::move(result), std::move(restored_join)}; });
}

/// True if a log should be joined without local maps, too: split and schedule were left automatic, the join was not settled,
/// and polishing has shown that the Gaussians of the maps are crude, being made far from the optimum.
bool may_do_without_maps(const RunFigures& figures, const RunOptions& options) {
  return options.split.rule == SplitRule::kAuto && options.schedule == Schedule::kAuto && figures.local_maps > 0 &&
         !figures.join.is_settled && figures.recovered_chi2 > (1.0 + kCrudeMaps) * figures.chi2;
}

/// True if two runs end at the same optimum, one of them from near by.
bool confirm_each_other(const RunFigures& one, const RunFigures& other) {
  return is_same_chi2(one.chi2, other.chi2) && (one.join.came_from_near_by() || other.join.came_from_near_by());
}

template <int Dim>
Expected<Found<Dim>> run_best(const Log<Dim>& log, const RunOptions& options, const std::stop_token& stop) {
  auto best = run_once(log, options, stop);
  if (!best || !may_do_without_maps(best->result, options)) return best;
  RunOptions without_maps = options;
  without_maps.split = {SplitRule::kPoses, 1.0};
  without_maps.schedule = Schedule::kUnbalanced;
  auto other = run_once(log, without_maps, stop);
  if (!other) return other.error().kind == ErrorKind::kInterrupted ? std::move(other) : std::move(best);
  if (is_less_chi2(other->result.chi2, best->result.chi2)) {
    std::swap(best, other);
    best->result.join.is_confirmed = best->result.join.kept_its_promises();
  } else if (confirm_each_other(best->result, other->result)) {
    best->result.join.is_confirmed = true;
  }
  best->result.seconds += other->result.seconds;
  return best;
}

/// Bad input if the start is kFile and some pose or feature has no initial value.
template <int Dim>
Expected<void> check_start(const Log<Dim>& log, Start start) {
  const bool has_values = !log.initial.poses.empty() && log.initial.features.size() == log.features.size();
  if (start != Start::kFile || has_values) return {};
  return bad_input_of(log.source, "not every pose and feature has a value to start from; --start composed and zero need none");
}
template <int Dim>
Expected<void> check_start(const SubmapSet<Dim>& set, Start start) {
  if (start != Start::kFile) return {};
  return bad_input_of(set.source, "local maps hold no values of the whole map to start from");
}

template <typename Data>
Expected<void> check(const Data& data, const RunOptions& options) {
  demand_valid(options);
  return check_start(data, options.start).and_then([&] { return check_connected(data); });
}

}  // namespace

std::function<void(std::size_t, std::size_t)> RunOptions::progress_of(Stage stage) const {
  if (!progress) return nullptr;
  return [this, stage](std::size_t done, std::size_t to_do) { progress(stage, done, to_do); };
}

std::vector<std::string> RunOptions::validate() const {
  std::vector<std::string> violations = split.validate();
  for (auto& violation : solver.validate()) violations.push_back(std::move(violation));
  if (rule_of(schedule).takes_start()) return violations;
  if (start != Start::kComposed) {
    violations.push_back("a " + to_string(start) + " start is for the batch schedule: the others need none");
  }
  if (gradual) violations.emplace_back("a path to the start is for the batch schedule: the others need none");
  return violations;
}

RunSeconds& RunSeconds::operator+=(const RunSeconds& others) {
  for (const auto stage : {&RunSeconds::build, &RunSeconds::join, &RunSeconds::recover, &RunSeconds::polish,
                           &RunSeconds::verdict, &RunSeconds::covariances}) {
    this->*stage += others.*stage;
  }
  return *this;
}

int RunFigures::path_iterations() const {
  return std::accumulate(path.begin(), path.end(), 0,
                         [](int sum, const PathPoint& point) { return sum + point.result.iterations; });
}

bool RunFigures::converged() const {
  if (polish) return polish->status == MinimiseStatus::kConverged;
  return join.status == MinimiseStatus::kConverged && unrecovered == 0;
}

template <int Dim>
Expected<RunResult<Dim>> run(const Log<Dim>& log, const RunOptions& options, const std::stop_token& stop) {
  return check(log, options).and_then([&] { return run_best(log, options, stop); }).and_then([&](Found<Dim> found) {
    return assessed(std::move(found), log.odometry(), options, stop);
  });
}

template <int Dim>
Expected<RunResult<Dim>> run_from_maps(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                       const RunOptions& options, const std::stop_token& stop) {
  return check(log, options)
      .and_then([&] { return check_local_maps(log, split, maps); })
      .and_then([&] { return join_and_refine(log, split, std::move(maps), options, stop); })
      .and_then([&](Found<Dim> found) { return assessed(std::move(found), log.odometry(), options, stop); });
}

template <int Dim>
Expected<RunResult<Dim>> run(SubmapSet<Dim> set, const RunOptions& options, const std::stop_token& stop) {
  return check_content(set)
      .and_then([&] { return check_segments(set); })
      .and_then([&] { return check(set, options); })
      .and_then([&] { return join_set(set, options, stop); })
      .and_then([&](Found<Dim> found) { return assessed<Dim>(std::move(found), {}, options, stop); });
}

template <int Dim>
Expected<RunResult<Dim>> solve(const Log<Dim>& log, RunOptions options, const std::stop_token& stop) {
  options.split = {SplitRule::kPoses, 1.0};
  options.polish = false;  // the join is full SLAM already
  return check(log, options)
      .and_then([&] { return join_and_refine<Dim>(log, split(log, options.split), {}, options, stop); })
      .and_then([&](Found<Dim> found) { return assessed(std::move(found), log.odometry(), options, stop); });
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                             \
  template Expected<RunResult<Dim>> run(const Log<Dim>&, const RunOptions&, const std::stop_token&);         \
  template Expected<RunResult<Dim>> run(SubmapSet<Dim>, const RunOptions&, const std::stop_token&);          \
  template Expected<RunResult<Dim>> run_from_maps(const Log<Dim>&, const Split&, std::vector<LocalMap<Dim>>, \
                                                  const RunOptions&, const std::stop_token&);                \
  template Expected<RunResult<Dim>> solve(const Log<Dim>&, RunOptions, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
