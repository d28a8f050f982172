// SPDX-License-Identifier: BSD-3-Clause
#include <apps/process.hpp>
#include <apps/report/associations.hpp>
#include <apps/report/report.hpp>
#include <apps/report/verdict.hpp>
#include <mapjoin/version.hpp>

namespace mapjoin::apps {
namespace {

Json json_of(const Inflation& inflation) {
  Json json;
  for (const auto& [name, factor] : kInflatedKinds) json[std::string(name)] = inflation.*factor;
  return json;
}

Json input_of(const RunReport& run_report) {
  const Counts& counts = run_report.counts;
  const Conventions& conventions = run_report.conventions;
  return {{"dimension", run_report.dimension},
          {"convention",
           {{"pose_error", conventions.pose_error},
            {"rotation_information", conventions.rotation_information},
            {"covariance", conventions.covariance},
            {"inflation", json_of(conventions.inflation)}}},
          {"units", {{"length", "m"}, {"angle", "rad"}}},
          {"sessions", counts.sessions},
          {"poses", counts.poses},
          {"features", counts.features},
          {"odometry", counts.odometry},
          {"closures", counts.closures},
          {"observations", counts.observations},
          {"priors", counts.priors},
          {"fixed_poses", counts.fixed_poses},
          {"stamps", run_report.has_stamps},
          {"repeated_edges", counts.repeated_edges},
          {"symmetrised_matrices", conventions.repairs.symmetrised},
          {"largest_asymmetry", conventions.repairs.largest_asymmetry},
          {"repaired_informations", conventions.repairs.indefinite},
          {"missing_informations", conventions.repairs.missing},
          {"unassociated", counts.unassociated},
          {"skipped", counts.skipped}};
}

Json local_maps_of(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  Json json = if_known(run_report.has_local_maps, {{"count", figures.local_maps},
                                                   {"spans", figures.raw_segments},
                                                   {"poses_per_map", figures.poses_per_map},
                                                   {"iterations", figures.build_iterations}});
  if (figures.poses_per_map == 0) json["poses_per_map"] = nullptr;
  if (run_report.is_resumed) json["iterations"] = nullptr;
  json["seconds"] = figures.seconds.build;
  return json;
}

/// The fit of each local map in the join.
Json map_fits_of(const RunReport& run_report) {
  Json fits = Json::array();
  for (std::size_t m = 0; m < run_report.map_bases.size(); ++m) {
    const MapFit& fit = run_report.figures.maps[m];
    fits.push_back(run_report.map_bases[m]);
    fits.back().update(
        Json{{"end", run_report.map_ends[m].key}, {"chi2", fit.chi2}, {"rows", fit.rows}, {"probability", fit.probability()}});
  }
  return fits;
}

/// The optimum at each weight of the non-quadratic part; null if the join was not by continuation.
Json path_of(const std::vector<PathPoint>& points) {
  Json path;
  for (const PathPoint& point : points) {
    path.push_back({{"share", point.weight}, {"chi2", point.result.chi2}, {"iterations", point.result.iterations}});
  }
  return path;
}

/// chi2 at the start and after each iteration.
std::vector<double> course_of(const MinimiseResult& result) {
  std::vector<double> course = {result.start_chi2};
  course.insert(course.end(), result.course.begin(), result.course.end());
  return course;
}

Json join_of(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  const RunOptions& options = run_report.options;
  const bool takes_start = rule_of(options.schedule).takes_start();
  Json json = {{"status", run_report.is_joined ? to_string(figures.join.status) : "not_run"},
               {"state", options.state},
               {"start", takes_start ? std::optional(options.start) : std::nullopt},
               {"schedule", options.schedule},
               {"confirmed", figures.join.is_confirmed},
               {"path", path_of(figures.path)},
               {"method", options.solver.method},
               {"engine", options.solver.engine}};
  json.update(if_known(run_report.is_joined, {{"iterations", figures.join.iterations},
                                              {"factorisations", figures.join.factorisations},
                                              {"turned", figures.join.largest_rotation},
                                              {"chi2", figures.join.chi2},
                                              {"course", course_of(figures.join)},
                                              {"dof", figures.join.dof},
                                              {"maps", map_fits_of(run_report)}}));
  json["seconds"] = figures.seconds.join;
  return json;
}

Json polish_of(const std::optional<MinimiseResult>& polish) {
  if (!polish) return {{"status", "not_run"}, {"iterations", nullptr}, {"chi2", nullptr}};
  return {{"status", polish->status}, {"iterations", polish->iterations}, {"chi2", polish->chi2}};
}

Json json_of(const Nees& nees) {
  Json json = if_known(nees.dimensions > 0, {{"value", nees.value},
                                             {"dimensions", nees.dimensions},
                                             {"least", nees.least()},
                                             {"most", nees.most()},
                                             {"probability", nees.probability()}});
  json["dimensions"] = nees.dimensions;
  return json;
}

Json certainty_of(const RunReport& run_report) {
  const Deviations deviations = run_report.deviations.value_or(Deviations{});
  const auto medians = [](const std::optional<Deviations::Median>& known) {
    const Deviations::Median median = known.value_or(Deviations::Median{});
    return if_known(known.has_value(), {{"in_map", median.in_map}, {"relative", median.relative}});
  };
  const Consistency consistency = run_report.consistency.value_or(Consistency{});
  return {{"estimate", run_report.covariances},
          {"median_deviation", {{"poses", medians(deviations.poses)}, {"features", medians(deviations.features)}}},
          {"nees",
           {{"poses", json_of(consistency.poses)},
            {"features", json_of(consistency.features)},
            {"joint", json_of(consistency.joint)}}}};
}

/// The key `gps` of the report: null without fixes.
Json gps_of(const std::optional<GpsReport>& gps) {
  if (!gps) return nullptr;
  const GeographicPoint& origin = gps->frame.origin();
  return {{"file", gps->file},
          {"lever", std::vector<double>(gps->lever.begin(), gps->lever.end())},
          {"origin", {{"latitude", origin.latitude}, {"longitude", origin.longitude}, {"height", origin.height}}},
          {"fixes", gps->fixes},
          {"left_out", gps->left_out},
          {"rejected", gps->rejected.size()}};
}

Json seconds_of(const RunReport& run_report) {
  Json json;
  for (const auto& [stage, seconds] : run_report.stages()) json[stage] = seconds;
  json["total"] = run_report.total_seconds();
  return json;
}

}  // namespace

Json report_head(const RunReport& run_report) {
  Json json = {{"schema_version", kReportSchemaVersion},
               {"version", kVersion},
               {"command", run_report.command},
               {"input", run_report.input}};
  json.update(input_of(run_report));
  json["gps"] = gps_of(run_report.gps);
  json["robust"] = robust_of(run_report);
  return json;
}

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string report(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  Json json = report_head(run_report);
  json["local_maps"] = local_maps_of(run_report);
  json["join"] = join_of(run_report);
  json["recover"] =
      if_known(figures.recovered_chi2.has_value(), {{"chi2", figures.recovered_chi2}, {"unrecovered", figures.unrecovered}});
  json["polish"] = polish_of(figures.polish);
  json.update(
      if_known(run_report.is_joined, {{"converged", figures.converged()}, {"chi2", figures.chi2}, {"dof", figures.dof}}));
  json["association"] = association_of(run_report);
  json.update(verdict_of(run_report));
  json["gauge"] = if_known(run_report.is_joined, {{"held_poses", run_report.anchored}});
  json["certainty"] = certainty_of(run_report);
  json["errors"] = json_of(run_report.errors);
  json["files"] = run_report.files;
  json["seconds"] = seconds_of(run_report);
  json["peak_memory_mb"] = peak_memory_mb();
  json["blas"] = blas_name();
  return text_of(json);
}

}  // namespace mapjoin::apps
