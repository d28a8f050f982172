// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/assess.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/localmap/check.hpp>
#include <mapjoin/localmap/recover.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/demand_valid.hpp>
#include <mapjoin/model/segment.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// What is wrong with the data is said of the file they came from.
Error of_source(const std::string& source, Error error) {
  if (error.kind == ErrorKind::kBadInput) error.message = source + ": " + error.message;
  return error;
}

template <int Dim>
JoinOptions<Dim> join_options(const RunOptions& options, const Pose<Dim>& origin) {
  JoinOptions<Dim> joining;
  joining.schedule = options.schedule;
  joining.state = options.state;
  joining.solver = options.solver;
  joining.origin = origin;
  joining.start = options.start;
  joining.seed = options.seed;
  joining.progress = options.progress_of(Stage::kJoin);
  return joining;
}

template <int Dim, template <int> typename Source>
void write_map(const Source<Dim>& source, Values<Dim> state, const std::vector<PoseIndex>& anchored, RunResult<Dim>& result) {
  result.map.pose_ids = source.poses;
  result.map.feature_ids = source.features;
  result.map.poses = std::move(state.poses);
  result.map.features = std::move(state.features);
  result.map.gauge = anchored;
  result.map.conventions = source.conventions;
}

template <int Dim>
std::vector<SegmentView<Dim>> segments_of(const Log<Dim>& log, const Split& split) {
  const auto maps = map_segments(split.segments);
  std::vector<SegmentView<Dim>> segments(maps.size());
  parallel_for(maps.size(), [&](std::size_t k) { segments[k] = segment_view(log, split, *maps[k]); });
  return segments;
}

template <int Dim>
std::int64_t information_bytes(const LocalMap<Dim>& map) {
  return static_cast<std::int64_t>(sizeof(double)) * map.information.size();
}

/// What a join says of itself.
template <int Dim>
void take_figures(const Join<Dim>& join, RunFigures& figures) {
  figures.join = join.result;
  figures.schedule = join.schedule;
  figures.is_settled = join.is_settled;
  figures.largest_rotation = join.largest_rotation;
  figures.join_dof = join.dof();
  figures.maps = join.maps;
  figures.joint_bytes += join.system->equations().factor_bytes();
}

template <int Dim>
Expected<Join<Dim>> join_maps(const Log<Dim>& log, const SubmapGraph<Dim>& graph, const RunOptions& options,
                              const std::stop_token& stop, const Values<Dim>* values, RunResult<Dim>& result) {
  const Stopwatch watch(result.seconds.join);
  JoinOptions<Dim> joining = join_options(options, origin_of(log));
  joining.values = values ? values : &log.initial;
  auto joined = join(graph, log.poses, log.features, joining, stop);
  if (!joined) return tl::unexpected(of_source(log.source, joined.error()));
  take_figures(*joined, result);
  return joined;
}

/// Puts what the local maps had eliminated into `state`.
template <int Dim>
void recover(const Log<Dim>& log, const Split& split, const SubmapGraph<Dim>& graph, const RunOptions& options,
             const std::stop_token& stop, Values<Dim>& state, RunResult<Dim>& result) {
  const Stopwatch watch(result.seconds.recover);
  if (options.progress) options.progress(Stage::kRecover, 0, 1);
  result.unrecovered = recover_interiors(log, split, graph.is_local, options.solver, state, stop);
  result.recovered_chi2 = result.chi2 = log_chi2(log, state).total();
  if (options.keep_recovered) result.recovered = state;
}

/// Minimises the chi2 of every observation of the log from the recovered estimate, `state`, which takes the result.
template <int Dim>
void refine(const Log<Dim>& log, Restored<Dim>& restored, const RunOptions& options, const std::stop_token& stop,
            Values<Dim>& state, RunResult<Dim>& result) {
  if (options.progress) options.progress(Stage::kPolish, 0, 1);
  MinimiseOptions solver = options.solver;
  solver.relative_chi2 *= kRefiningShare;
  result.polish = minimise(restored.problem, solver, stop);
  write_values(restored.problem.estimate(), restored.joined_map.poses, restored.joined_map.features, state);
  result.chi2 = log_chi2(log, state).total();
}

/// Joins local maps, recovers what they eliminated, and refines the whole.
template <int Dim>
Expected<Found<Dim>> join_and_refine(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                     const RunOptions& options, const std::stop_token& stop, RunResult<Dim> result = {},
                                     const Values<Dim>* values = nullptr) {
  if (auto given = check_start(log, options.start); !values && !given) return tl::unexpected(given.error());
  result.local_maps = maps.size();
  result.raw_segments = split.segments.size() - maps.size();
  result.poses_per_map = split.poses_per_map;
  for (const LocalMap<Dim>& map : maps) result.joint_bytes += information_bytes(map);
  const SubmapGraph<Dim> graph = submap_graph_of(log, split, std::move(maps));
  auto joined = join_maps(log, graph, options, stop, values, result);
  if (!joined) return tl::unexpected(joined.error());
  // A join of the whole log has counted its rows already.
  result.dof = result.local_maps > 0 ? degrees_of_freedom(log, joined->anchored.size()) : joined->dof();
  Values<Dim> state = std::move(joined->state);
  recover(log, split, graph, options, stop, state, result);

  std::optional<Restored<Dim>> joined_map;
  const bool is_refined = options.polish && result.local_maps > 0;  // else the join was of the whole log
  if (is_refined || wants_assessment(options)) {
    const Stopwatch watch(is_refined ? result.seconds.polish : result.seconds.covariances);
    joined_map.emplace(restored(graph, segments_of(log, split), *joined, state, options.solver.engine));
    joined->system.reset();
    if (is_refined) refine(log, *joined_map, options, stop, state, result);
  }
  if (stop.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted while polishing"});
  write_map(log, std::move(state), joined->anchored, result);
  result.map.stamps_ns = log.stamps_ns;
  return Found<Dim>{std::move(result), std::move(joined_map)};
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

template <int Dim>
Expected<void> check_set(const SubmapSet<Dim>& set, const RunOptions& options, const Values<Dim>* values) {
  demand_valid(options);
  if (auto given = check_start(set, options.start); !values && !given) return given;
  return check_numbers(set).and_then([&] { return check_connected(set); });
}

/// Joins the maps of a set, which need not hold them any more.
template <int Dim>
Expected<RunResult<Dim>> join_set(const SubmapSet<Dim>& set, std::vector<LocalMap<Dim>> maps, const RunOptions& options,
                                  const std::stop_token& stop, const Values<Dim>* values = nullptr) {
  RunResult<Dim> result;
  result.local_maps = maps.size();
  for (const LocalMap<Dim>& map : maps) result.joint_bytes += information_bytes(map);
  const SubmapGraph<Dim> graph = submap_graph_of(set, std::move(maps));
  auto joined = [&] {
    const Stopwatch watch(result.seconds.join);
    JoinOptions<Dim> joining = join_options(options, Pose<Dim>{});
    joining.values = values;
    return join(graph, set.poses, set.features, joining, stop);
  }();
  if (!joined) return tl::unexpected(of_source(set.source, joined.error()));
  take_figures(*joined, result);
  result.dof = joined->dof();
  result.chi2 = joined->result.chi2;
  std::optional<Restored<Dim>> joined_map;
  if (wants_assessment(options)) joined_map.emplace(restored(graph, {}, *joined, joined->state, options.solver.engine));
  write_map(set, std::move(joined->state), joined->anchored, result);
  return assessed<Dim>({std::move(result), std::move(joined_map)}, {}, options, stop);
}

/// Whether a log that was left to be cut as is cheapest is joined without local maps, too: where their Gaussians proved crude,
/// for they were made far from the optimum, and the join was not settled. It takes polishing to tell.
bool may_do_without_maps(const RunFigures& figures, const RunOptions& options) {
  return options.split.rule == SplitRule::kAuto && options.schedule == Schedule::kAuto && figures.local_maps > 0 &&
         !figures.is_settled && figures.recovered_chi2 > (1.0 + kCrudeMaps) * figures.chi2;
}

}  // namespace

std::function<void(std::size_t, std::size_t)> RunOptions::progress_of(Stage stage) const {
  if (!progress) return nullptr;
  return [this, stage](std::size_t done, std::size_t to_do) { progress(stage, done, to_do); };
}

std::vector<std::string> RunOptions::validate() const {
  std::vector<std::string> violations = split.validate();
  for (auto& violation : solver.validate()) violations.push_back(std::move(violation));
  const bool takes_start = rule_of(schedule).takes_start();
  if (start != Start::kComposed && !takes_start) {
    violations.push_back("a " + to_string(start) + " start is for the batch schedule: the others need none");
  }
  return violations;
}

template <int Dim>
Expected<void> check_start(const Log<Dim>& log, Start start) {
  const bool has_values = !log.initial.poses.empty() && log.initial.features.size() == log.features.size();
  if (start != Start::kFile || has_values) return {};
  return bad_input(log.source + ": not every pose and feature has a value to start from");
}

template <int Dim>
Expected<void> check_start(const SubmapSet<Dim>& set, Start start) {
  if (start != Start::kFile) return {};
  return bad_input(set.source + ": local maps hold no values of the whole map to start from");
}

RunSeconds& RunSeconds::operator+=(const RunSeconds& others) {
  for (const auto stage : {&RunSeconds::build, &RunSeconds::join, &RunSeconds::recover, &RunSeconds::polish,
                           &RunSeconds::verdict, &RunSeconds::covariances}) {
    this->*stage += others.*stage;
  }
  return *this;
}

bool RunFigures::converged() const {
  if (polish) return polish->status == MinimiseStatus::kConverged;
  return join.status == MinimiseStatus::kConverged && unrecovered == 0;
}

template <int Dim>
Expected<RunResult<Dim>> run(const Log<Dim>& log, const RunOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto connected = check_connected(log); !connected) return tl::unexpected(connected.error());
  auto best = run_once(log, options, stop);
  if (!best) return tl::unexpected(best.error());
  if (!may_do_without_maps(best->result, options)) return assessed(*std::move(best), log.odometry(), options, stop);
  RunOptions without_maps = options;
  without_maps.split = {SplitRule::kPoses, 1.0};
  without_maps.schedule = Schedule::kUnbalanced;
  auto other = run_once(log, without_maps, stop);
  if (!other && other.error().kind == ErrorKind::kInterrupted) return tl::unexpected(other.error());
  if (other && is_less_chi2(other->result.chi2, best->result.chi2)) std::swap(best, other);
  if (other) best->result.seconds += other->result.seconds;
  return assessed(*std::move(best), log.odometry(), options, stop);
}

template <int Dim>
Expected<RunResult<Dim>> run_from_maps(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                       const RunOptions& options, const std::stop_token& stop, const Values<Dim>* values) {
  demand_valid(options);
  if (auto connected = check_connected(log); !connected) return tl::unexpected(connected.error());
  if (auto of_log = check_local_maps(log, split, maps); !of_log) return tl::unexpected(of_log.error());
  return join_and_refine(log, split, std::move(maps), options, stop, {}, values).and_then([&](Found<Dim> found) {
    return assessed(std::move(found), log.odometry(), options, stop);
  });
}

template <int Dim>
Expected<RunResult<Dim>> run(const SubmapSet<Dim>& set, const RunOptions& options, const std::stop_token& stop,
                             const Values<Dim>* values) {
  return check_set(set, options, values).and_then([&] { return join_set(set, set.graph.submaps, options, stop, values); });
}

template <int Dim>
Expected<RunResult<Dim>> run(SubmapSet<Dim>&& set, const RunOptions& options, const std::stop_token& stop) {
  return check_set<Dim>(set, options, nullptr).and_then([&] {
    return join_set(set, std::move(set.graph.submaps), options, stop);
  });
}

template <int Dim>
Expected<RunResult<Dim>> solve(const Log<Dim>& log, RunOptions options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto connected = check_connected(log); !connected) return tl::unexpected(connected.error());
  options.split = {SplitRule::kPoses, 1.0};
  options.polish = false;  // the join is full SLAM already
  return join_and_refine<Dim>(log, split(log, options.split), {}, options, stop).and_then([&](Found<Dim> found) {
    return assessed(std::move(found), log.odometry(), options, stop);
  });
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                               \
  template Expected<RunResult<Dim>> run(const Log<Dim>&, const RunOptions&, const std::stop_token&);                           \
  template Expected<RunResult<Dim>> run(const SubmapSet<Dim>&, const RunOptions&, const std::stop_token&, const Values<Dim>*); \
  template Expected<RunResult<Dim>> run(SubmapSet<Dim>&&, const RunOptions&, const std::stop_token&);                          \
  template Expected<RunResult<Dim>> run_from_maps(const Log<Dim>&, const Split&, std::vector<LocalMap<Dim>>,                   \
                                                  const RunOptions&, const std::stop_token&, const Values<Dim>*);              \
  template Expected<void> check_start(const Log<Dim>&, Start);                                                                 \
  template Expected<void> check_start(const SubmapSet<Dim>&, Start);                                                           \
  template Expected<RunResult<Dim>> solve(const Log<Dim>&, RunOptions, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
