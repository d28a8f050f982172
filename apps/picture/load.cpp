// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/picture/load.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/localmap/split.hpp>

namespace mapjoin::apps {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLeastStops = 12;
constexpr std::size_t kMostStops = 100;
constexpr std::size_t kMostPlaces = 500'000;  // of all stops together: 6 MB

/// How many segments to join between two stops.
template <int Dim>
std::size_t between_stops(const SubmapGraph<Dim>& graph) {
  const auto places =
      static_cast<std::size_t>(std::ranges::count(graph.is_joined, true) + std::ranges::count(graph.is_local, false));
  const std::size_t stops = std::clamp(2 * kMostPlaces / std::max<std::size_t>(places, 1), kLeastStops, kMostStops);
  return (graph.segments.size() + stops - 1) / stops;
}

/// The map in the folder of a run, else the path as it is.
fs::path file_of(const fs::path& path) {
  std::error_code ignored;
  const fs::path map = path / "map.g2o";
  return fs::is_regular_file(map, ignored) ? map : path;
}

template <int Dim>
LoadedMap loaded(const Log<Dim>& log, const fs::path& path) {
  PlottedMap<Dim> out = plotted(log);
  if (!out.is_odometry) {
    read_covariances_beside(path, out.map);
    out.local_maps = plotted_local_maps(read_fits_beside(path, log.poses), log);
  }
  return {std::move(out)};
}

template <int Dim>
LoadedMap of_result(RunResult<Dim>& result, const SubmapGraph<Dim>& graph, PlottedMap<Dim> out, const LoadOptions& options,
                    const std::stop_token& stop) {
  if (result.marginals) {
    out.map.pose_covariances = std::move(result.marginals->poses);
    out.map.feature_covariances = std::move(result.marginals->features);
  }
  if (options.has_stops) out.stops = join_stops(graph, out.map, options.progress, stop);
  LoadedMap joined{std::move(out)};
  if (result.no_covariances) {
    joined.exit_code = ExitCode::kBadInput;
    joined.remarks.push_back(result.no_covariances->message + "; it is drawn without covariances");
  }
  if (!result.converged()) {
    joined.exit_code = ExitCode::kDidNotConverge;
    joined.remarks.emplace_back("the join did not converge; it is drawn all the same");
  }
  return joined;
}

template <int Dim>
LoadedMap loaded(const SubmapSet<Dim>& set, const LoadOptions& options, const std::stop_token& stop) {
  RunResult<Dim> result = run(set, options.run, stop).value();
  return of_result(result, submap_graph_of(set), plotted(result, set), options, stop);
}

template <int Dim>
LoadedMap loaded(const StoredMaps<Dim>& stored, const LoadOptions& options, const std::stop_token& stop) {
  const Split parts = split_along(stored.log, stored.segments);
  RunResult<Dim> result = run_from_maps(stored.log, parts, stored.maps, options.run, stop).value();
  return of_result(result, submap_graph_of(stored.log, parts, stored.maps), plotted(result, stored.log), options, stop);
}

}  // namespace

template <int Dim>
std::vector<JoinStop<Dim>> join_stops(const SubmapGraph<Dim>& graph, const GlobalMap<Dim>& map,
                                      const std::function<void(std::size_t, std::size_t)>& progress,
                                      const std::stop_token& stop) {
  std::vector<JoinStop<Dim>> stops;
  const JoinWatch<Dim> watch = [&](std::size_t segments, const JoinedPartialMaps<Dim>& joined) {
    const PartialMap<Dim>& partial = joined.partials.front();
    const Pose<Dim>& first = map.poses[partial.poses.front()];
    const Pose<Dim> frame = compose(first, inverse(partial.state.poses.front()));
    stops.push_back({segments, partial_map_chi2(partial), partial.poses, moved(frame, partial.state)});
  };
  watch_join(graph, between_stops(graph), watch, progress, stop);
  return stops;
}

LoadedMap load(const fs::path& path, const LoadOptions& options, const std::stop_token& stop) {
  const fs::path file = file_of(path);
  if (may_hold_maps(file)) {
    const AnyMaps maps = open_maps(file, options.read).value();
    return std::visit([&](const auto& of_dim) { return loaded(of_dim, options, stop); }, maps);
  }
  const AnyLog log = open_log(file, options.read).value();
  return std::visit([&](const auto& of_dim) { return loaded(of_dim, file); }, log);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                       \
  template std::vector<JoinStop<Dim>> join_stops(const SubmapGraph<Dim>&, const GlobalMap<Dim>&,       \
                                                 const std::function<void(std::size_t, std::size_t)>&, \
                                                 const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
