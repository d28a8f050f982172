// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/outputs.hpp>
#include <apps/picture/links.hpp>
#include <apps/picture/load.hpp>
#include <apps/report/report.hpp>
#include <mapjoin/geometry/upper_triangle.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/run_folder.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/lists.hpp>
#include <nlohmann/json.hpp>

namespace mapjoin::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::size_t kLeastStops = 12;
constexpr std::size_t kMostStops = 100;
constexpr std::size_t kMostPlaces = 500'000;  // of all stops together: 6 MB

/// The number of segments to join between two stops.
template <int Dim>
std::size_t between_stops(const SubmapGraph<Dim>& graph) {
  const auto places =
      static_cast<std::size_t>(std::ranges::count(graph.is_joined, true) + std::ranges::count(graph.is_local, false));
  const std::size_t stops = std::clamp(2 * kMostPlaces / std::max<std::size_t>(places, 1), kLeastStops, kMostStops);
  return (graph.segments.size() + stops - 1) / stops;
}

/// The result of `take` on the JSON in a file; bad input if a value is missing or of another type.
template <typename Take>
auto from_json(const fs::path& file, Take&& take) {
  const FileBytes bytes = FileBytes::read(file).value();
  try {
    return take(Json::parse(bytes.view()));
  } catch (const Json::exception&) {
    fail(ErrorKind::kBadInput, file.string() + ": is not as this mapjoin writes it; remove it, or make it anew with the map");
  }
}

/// The symmetric matrix with this upper triangle; throws if there are too few numbers.
template <int Size>
Matrix<Size> symmetric(const Json& upper) {
  std::size_t next = 0;
  return from_upper_triangle<Size>([&] { return upper.at(next++).get<double>(); });
}

template <int Dim>
Point<Dim> position_in(const Json& line) {
  Point<Dim> position;
  for (int i = 0; i < Dim; ++i) position[i] = line.at("position").at(static_cast<std::size_t>(i)).get<double>();
  return position;
}

PoseId pose_id(const Json& line, const char* key = "pose") {
  return {line.at("session").get<std::uint32_t>(), line.at(key).get<std::uint64_t>()};
}

/// The map in a file of its covariances, without rotations.
template <int Dim>
GlobalMap<Dim> map_of_covariances(const Json& json) {
  GlobalMap<Dim> map;
  for (const Json& line : json.at("poses")) {
    map.pose_ids.push_back(pose_id(line));
    map.poses.push_back({position_in<Dim>(line), {}});
    map.pose_covariances.push_back(symmetric<kPoseDof<Dim>>(line.at("covariance")));
  }
  for (const Json& line : json.at("features")) {
    map.feature_ids.push_back({line.at("feature").get<std::uint64_t>()});
    map.features.push_back(position_in<Dim>(line));
    map.feature_covariances.push_back(symmetric<Dim>(line.at("covariance")));
  }
  return map;
}

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

/// The folder of a run if this is one, or the `map.g2o` in it; nullopt otherwise.
std::optional<fs::path> run_of(const fs::path& path) {
  const fs::path parent = path.has_parent_path() ? path.parent_path() : ".";
  const bool is_its_map =
      path.filename() == kMapOfRun && is_there(path) && is_there(parent / kReportOfRun) && is_there(parent / kPosesOfRun);
  const fs::path& folder = is_its_map ? parent : path;
  return is_run_folder(folder) ? std::optional(folder) : std::nullopt;
}

/// The file of covariances of a map: `covariances.json` in the folder of its run, `map.covariances.json` beside `map.g2o`;
/// nullopt if there is none, and for a trajectory, which has no names.
std::optional<fs::path> covariances_beside(const fs::path& path, const std::optional<fs::path>& run) {
  if (!run && extension_of(path) == ".tum") return std::nullopt;
  const fs::path file = run ? *run / name_in_folder(Extra::kCovariances) : extra_file(Extra::kCovariances, path);
  return is_there(file) ? std::optional(file) : std::nullopt;
}

/// The map in a file of covariances.
template <int Dim>
GlobalMap<Dim> read_covariances(const fs::path& file) {
  return from_json(file, [&](const Json& json) {
    if (json.at("dimension") != Dim) demand(not_of_map_beside(file));
    return map_of_covariances<Dim>(json);
  });
}

/// Puts the covariances that were told into a map under the same names, which may have no features.
template <int Dim>
void take_covariances(GlobalMap<Dim> told, GlobalMap<Dim>& map) {
  map.pose_covariances = std::move(told.pose_covariances);  // in the order of with_names()
  map.feature_covariances.assign(map.features.size(), PointMatrix<Dim>::Zero());
  const IndexOf index_of(map.feature_ids);
  for (const FeatureIndex f : indices(told.features)) {
    if (const auto here = index_of(told.feature_ids[f])) map.feature_covariances[*here] = told.feature_covariances[f];
  }
}

/// The fits of the local maps of a run, from its report; empty if that does not say where they end. Bad input if it is not of
/// the map with these poses.
std::vector<MapFit> read_fits(const fs::path& file, const PoseIds& poses) {
  const IndexOf index_of(poses);
  return from_json(file, [&](const Json& json) {
    std::vector<MapFit> fits;
    for (const Json& line : json.at("join").at("maps")) {
      if (!line.contains("end")) return std::vector<MapFit>();
      const auto base = index_of(pose_id(line));
      const auto end = index_of(pose_id(line, "end"));
      if (!base || !end || *end < *base) demand(not_of_map_beside(file));
      fits.push_back({base.value(), end.value(), line.at("chi2").get<double>(), line.at("rows").get<std::int64_t>()});
    }
    return fits;
  });
}

/// Reads local maps and rejected links from the folder of a run; returns, in words, why it could not.
template <int Dim>
std::vector<std::string> read_run(const fs::path& folder, const Log<Dim>& log, PlottedMap<Dim>& out) {
  const fs::path run_report = folder / kReportOfRun;
  const fs::path rejected = folder / name_in_folder(Extra::kRejected);
  if (!is_there(run_report) && !is_there(rejected)) return {};
  for (const char* table : {kPosesOfRun, kFeaturesOfRun}) {
    if (!is_there(folder / table)) {
      return {fmt::format("without its {} neither local maps nor what was rejected are drawn", table)};
    }
  }
  if (is_there(run_report)) out.local_maps = plotted_local_maps(read_fits(run_report, log.poses), log);
  if (is_there(rejected)) add_rejected_links(rejected, log.poses, log.features, out.links);
  return {};
}

/// A log in a file, or in the folder of a run.
template <int Dim>
LoadedMap loaded(Log<Dim> log, const fs::path& path, const std::optional<fs::path>& run) {
  std::optional<GlobalMap<Dim>> certain;
  if (const auto file = log.initial.poses.empty() ? std::nullopt : covariances_beside(path, run)) {
    certain = read_covariances<Dim>(*file);
    log = with_names(*certain, std::move(log), *file).value();
  }
  PlottedMap<Dim> out = plotted(log);
  if (certain) take_covariances(*std::move(certain), out.map);
  std::vector<std::string> remarks;
  if (!log.skipped.empty()) remarks.push_back(left_out_in_words(log.skipped));
  if (run) append(remarks, read_run(*run, log, out));
  return {std::move(out), ExitCode::kDone, std::move(remarks)};
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
  const std::optional<fs::path> run = run_of(path);
  if (!run && may_hold_maps(path)) {
    const AnyMaps maps = open_maps(path, options.read).value();
    return std::visit([&](const auto& of_dim) { return loaded(of_dim, options, stop); }, maps);
  }
  AnyLog log = run ? read_run_folder(*run, options.read).value() : open_log(path, options.read).value();
  return std::visit([&](auto& of_dim) { return loaded(std::move(of_dim), path, run); }, log);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                       \
  template std::vector<JoinStop<Dim>> join_stops(const SubmapGraph<Dim>&, const GlobalMap<Dim>&,       \
                                                 const std::function<void(std::size_t, std::size_t)>&, \
                                                 const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
