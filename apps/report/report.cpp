// SPDX-License-Identifier: BSD-3-Clause
#include <apps/blas.hpp>
#include <apps/report/report.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/version.hpp>
#include <nlohmann/json.hpp>

namespace mapjoin::apps {
namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json value_if(bool known, const T& value) {
  return known ? Json(value) : Json();
}

Json input_of(const RunReport& run_report) {
  const Counts& counts = run_report.counts;
  return {{"dimension", run_report.dimension},
          {"convention",
           {{"pose_error", to_string(run_report.conventions.pose_error)},
            {"rotation_information", to_string(run_report.conventions.rotation_information)},
            {"covariance", to_string(run_report.conventions.covariance)}}},
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
          {"symmetrised_matrices", run_report.conventions.repairs.symmetrised},
          {"largest_asymmetry", run_report.conventions.repairs.largest_asymmetry},
          {"repaired_informations", run_report.conventions.repairs.indefinite},
          {"unassociated", counts.unassociated}};
}

Json gauge_of(const RunReport& run_report) {
  Json held = Json::array();
  for (const PoseId& id : run_report.held) held.push_back({{"session", id.session}, {"pose", id.key}});
  return {{"held_poses", value_if(run_report.is_joined, held)}};
}

Json local_maps_of(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  const bool known = run_report.has_local_maps;
  return {{"count", value_if(known, figures.local_maps)},
          {"spans", value_if(known, figures.spans)},
          {"poses_per_map", value_if(known && figures.poses_per_map > 0, figures.poses_per_map)},
          {"iterations", value_if(known && !run_report.is_resumed, figures.build_iterations)},
          {"seconds", figures.seconds.build}};
}

/// How each local map fits into the join.
Json map_fits_of(const RunReport& run_report) {
  Json fits = Json::array();
  for (std::size_t m = 0; m < run_report.map_bases.size(); ++m) {
    const MapFit& fit = run_report.figures.maps[m];
    fits.push_back({{"session", run_report.map_bases[m].session},
                    {"pose", run_report.map_bases[m].key},
                    {"end", run_report.map_ends[m].key},
                    {"chi2", fit.chi2},
                    {"rows", fit.rows},
                    {"probability", fit.probability()}});
  }
  return fits;
}

/// The optimum at each share of what is not quadratic; null where the join was not gradual.
Json path_of(const RunFigures& figures) {
  Json path;
  for (const PathPoint& point : figures.path) {
    path.push_back({{"share", point.share}, {"chi2", point.result.chi2}, {"iterations", point.result.iterations}});
  }
  return path;
}

/// chi2 from the start on, and after each iteration.
Json course_of(const MinimiseResult& result) {
  Json course = {result.start_chi2};
  for (const double chi2 : result.course) course.push_back(chi2);
  return course;
}

Json join_of(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  const bool done = run_report.is_joined;
  return {{"status", done ? to_string(figures.join.status) : "not_run"},
          {"state", to_string(run_report.state)},
          {"start", value_if(rule_of(run_report.schedule).takes_start(), to_string(run_report.start_values))},
          {"schedule", to_string(run_report.schedule)},
          {"path", path_of(figures)},
          {"method", to_string(run_report.method)},
          {"engine", to_string(run_report.engine)},
          {"iterations", value_if(done, figures.join.iterations)},
          {"factorisations", value_if(done, figures.join.factorisations)},
          {"turned", value_if(done, figures.turned)},
          {"chi2", value_if(done, figures.join.chi2)},
          {"course", value_if(done, course_of(figures.join))},
          {"dof", value_if(done, figures.join_dof)},
          {"maps", value_if(done, map_fits_of(run_report))},
          {"seconds", figures.seconds.join}};
}

Json polish_of(const RunReport& run_report) {
  if (!run_report.figures.polish) return {{"status", "not_run"}, {"iterations", nullptr}, {"chi2", nullptr}};
  const MinimiseResult& polish = *run_report.figures.polish;
  return {{"status", to_string(polish.status)}, {"iterations", polish.iterations}, {"chi2", polish.chi2}};
}

Json nees_of(const std::optional<Consistency>& consistency, Nees Consistency::*part) {
  const Nees nees = consistency ? (*consistency).*part : Nees{};
  const bool known = nees.dimensions > 0;
  return {{"value", value_if(known, nees.value)},
          {"dimensions", nees.dimensions},
          {"least", value_if(known, nees.least())},
          {"most", value_if(known, nees.most())},
          {"probability", value_if(known, nees.probability())}};
}

Json certainty_of(const RunReport& run_report) {
  const auto deviations = run_report.deviations.value_or(Deviations{});
  const auto medians = [&](const Deviations::Median& of) {
    const bool known = run_report.deviations.has_value();
    return Json{{"in_map", value_if(known, of.in_map)}, {"relative", value_if(known, of.relative)}};
  };
  return {{"estimate", run_report.covariances ? Json(to_string(*run_report.covariances)) : Json()},
          {"median_deviation", {{"poses", medians(deviations.poses)}, {"features", medians(deviations.features)}}},
          {"nees",
           {{"poses", nees_of(run_report.consistency, &Consistency::poses)},
            {"features", nees_of(run_report.consistency, &Consistency::features)},
            {"joint", nees_of(run_report.consistency, &Consistency::joint)}}}};
}

Json seconds_of(const RunReport& run_report) {
  const RunSeconds& seconds = run_report.figures.seconds;
  return {{"read", run_report.read_seconds},
          {"build", seconds.build},
          {"join", seconds.join},
          {"recover", seconds.recover},
          {"polish", seconds.polish},
          {"covariances", seconds.covariances},
          {"write", run_report.write_seconds},
          {"total", run_report.total_seconds()}};
}

}  // namespace

Json report_head(const RunReport& run_report) {
  Json json = {{"schema_version", kReportSchemaVersion},
               {"version", kVersion},
               {"command", run_report.command},
               {"input", run_report.input}};
  json.update(input_of(run_report));
  return json;
}

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string report(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  const auto& recovered = figures.recovered_chi2;
  Json json = report_head(run_report);
  json["local_maps"] = local_maps_of(run_report);
  json["join"] = join_of(run_report);
  json["recover"] = {{"chi2", value_if(recovered.has_value(), recovered.value_or(0.0))},
                     {"unrecovered", value_if(recovered.has_value(), figures.unrecovered)}};
  json["polish"] = polish_of(run_report);
  json["converged"] = value_if(run_report.is_joined, figures.converged());
  json["chi2"] = value_if(run_report.is_joined, figures.chi2);
  json["dof"] = value_if(run_report.is_joined, figures.dof);
  json["gauge"] = gauge_of(run_report);
  json["certainty"] = certainty_of(run_report);
  json["files"] = run_report.files;
  json["seconds"] = seconds_of(run_report);
  json["peak_memory_mb"] = peak_memory_mb();
  json["blas"] = blas_name();
  return text_of(json);
}

Expected<void> write_report(const RunReport& run_report, const std::filesystem::path& path) {
  return write_file(path, report(run_report));
}

}  // namespace mapjoin::apps
