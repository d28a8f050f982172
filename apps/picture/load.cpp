// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/outputs.hpp>
#include <apps/picture/links.hpp>
#include <apps/picture/load.hpp>
#include <apps/picture/log_names.hpp>
#include <mapjoin/geometry/upper_triangle.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/localmap/split.hpp>
#include <nlohmann/json.hpp>

namespace mapjoin::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

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

/// What `take` makes of the JSON in a file. What it does not find there, or finds to be something else, is bad input.
template <typename Take>
auto from_json(const fs::path& file, Take&& take) {
  const FileBytes bytes = FileBytes::read(file).value();
  try {
    return take(Json::parse(bytes.view()));
  } catch (const Json::exception&) {
    fail(ErrorKind::kBadInput, file.string() + ": is not as this mapjoin writes it; remove it, or make it anew with the map");
  }
}

/// Symmetric, from its upper triangle; throws where there are not as many numbers.
template <int Size>
Matrix<Size> symmetric(const Json& upper) {
  std::size_t next = 0;
  return from_upper_triangle<Size>([&] { return upper.at(next++).get<double>(); });
}

template <int Dim>
Point<Dim> position_of(const Json& line) {
  Point<Dim> position;
  for (int i = 0; i < Dim; ++i) position[i] = line.at("position").at(static_cast<std::size_t>(i)).get<double>();
  return position;
}

PoseId pose_id(const Json& line, const char* key = "pose") {
  return {line.at("session").get<std::uint32_t>(), line.at(key).get<std::uint64_t>()};
}

/// A map as a file of its covariances has it: without its rotations.
template <int Dim>
GlobalMap<Dim> map_of_covariances(const Json& json) {
  GlobalMap<Dim> map;
  for (const Json& line : json.at("poses")) {
    map.pose_ids.push_back(pose_id(line));
    map.poses.push_back({position_of<Dim>(line), {}});
    map.pose_covariances.push_back(symmetric<kPoseDof<Dim>>(line.at("covariance")));
  }
  for (const Json& line : json.at("features")) {
    map.feature_ids.push_back({line.at("feature").get<std::uint64_t>()});
    map.features.push_back(position_of<Dim>(line));
    map.feature_covariances.push_back(symmetric<Dim>(line.at("covariance")));
  }
  return map;
}

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

/// Puts the covariances of `map.covariances.json` beside `map.g2o`, or of `covariances.json` in the folder of a run, into the
/// map that was read from there. Nothing where there are none, and for a trajectory, which has no names; bad input where they
/// are not of this map.
template <int Dim>
void read_covariances_beside(const fs::path& path, GlobalMap<Dim>& map) {
  fs::path file = extra_file(Extra::kCovariances, path);
  if (path.filename() == kMapOfRun && !is_there(file)) file = path.parent_path() / "covariances.json";
  if (!is_there(file) || extension_of(path) == ".tum") return;
  from_json(file, [&](const Json& json) {
    if (json.at("dimension") != Dim) fail_not_of_map(file);
    const auto told = map_of_covariances<Dim>(json);
    const LogNames names(file, told, map);
    map.pose_covariances.assign(map.poses.size(), PoseMatrix<Dim>::Zero());
    map.feature_covariances.assign(map.features.size(), PointMatrix<Dim>::Zero());
    for (const PoseIndex p : indices(told.poses)) map.pose_covariances[*names(told.pose_ids[p])] = told.pose_covariances[p];
    for (const FeatureIndex f : indices(told.features)) {
      if (const auto here = names(told.feature_ids[f])) map.feature_covariances[*here] = told.feature_covariances[f];
    }
  });
}

/// How the local maps of a run fit, by the `report.json` in its folder, over the poses of its map. Empty where there is none or
/// it does not say where they end, and where it is not in the folder of a run. Bad input where it is not of this map.
template <int Dim>
std::vector<MapFit> read_fits_beside(const fs::path& path, const GlobalMap<Dim>& map) {
  const fs::path folder = path.parent_path();
  const fs::path file = folder / kReportOfRun;
  if (path.filename() != kMapOfRun || !is_there(file) || !is_there(folder / "poses.csv")) return {};
  return from_json(file, [&](const Json& json) {
    std::vector<MapFit> fits;
    const LogNames names = LogNames::of_run(folder, map);
    for (const Json& line : json.at("join").at("maps")) {
      if (!line.contains("end")) return std::vector<MapFit>();
      const auto base = names(pose_id(line));
      const auto end = names(pose_id(line, "end"));
      if (!base || !end || *end < *base) fail_not_of_map(file);
      fits.push_back({*base, *end, line.at("chi2").get<double>(), line.at("rows").get<std::int64_t>()});
    }
    return fits;
  });
}

template <int Dim>
LoadedMap loaded(const Log<Dim>& log, const fs::path& path) {
  PlottedMap<Dim> out = plotted(log);
  if (!out.is_odometry) {
    read_covariances_beside(path, out.map);
    out.local_maps = plotted_local_maps(read_fits_beside(path, out.map), log);
    if (path.filename() == kMapOfRun) add_rejected_links(path.parent_path(), out.map, out.links);
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
  const fs::path file = map_of_run(path);
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
