// SPDX-License-Identifier: BSD-3-Clause
#include <apps/report.hpp>
#include <apps/words.hpp>
#include <mapjoin/io/output_file.hpp>
#include <mapjoin/solve/blas.hpp>
#include <mapjoin/version.hpp>
#include <nlohmann/json.hpp>

namespace mapjoin::apps {
namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json value_if(bool known, const T& value) {
  return known ? Json(value) : Json();
}

Json input_of(const Account& account) {
  const Counts& counts = account.counts;
  return {{"dimension", account.dimension},
          {"convention",
           {{"pose_error", word(account.conventions.pose_error)},
            {"rotation_information", word(account.conventions.rotation_information)},
            {"covariance", word(account.conventions.covariance)}}},
          {"units", {{"length", "m"}, {"angle", "rad"}}},
          {"sessions", counts.sessions},
          {"poses", counts.poses},
          {"features", counts.features},
          {"odometry", counts.odometry},
          {"closures", counts.closures},
          {"observations", counts.observations},
          {"priors", counts.priors},
          {"fixed_poses", counts.fixed_poses},
          {"stamps", account.has_stamps},
          {"repeated_edges", counts.repeated_edges},
          {"repaired_informations", account.conventions.repaired_informations},
          {"unassociated", counts.unassociated}};
}

Json gauge_of(const Account& account) {
  Json held = Json::array();
  for (const PoseId& id : account.held) held.push_back({{"session", id.session}, {"pose", id.key}});
  return {{"held_poses", value_if(account.is_joined, held)}};
}

Json local_maps_of(const Account& account) {
  const RunFigures& figures = account.figures;
  const bool known = account.has_local_maps;
  return {{"count", value_if(known, figures.local_maps)},
          {"spans", value_if(known, figures.spans)},
          {"poses_per_map", value_if(known && figures.poses_per_map > 0, figures.poses_per_map)},
          {"iterations", value_if(known && !account.is_resumed, figures.build_iterations)},
          {"seconds", figures.seconds.build}};
}

/// How each local map fits into the join.
Json map_fits_of(const Account& account) {
  Json fits = Json::array();
  for (std::size_t m = 0; m < account.map_bases.size(); ++m) {
    const MapFit& fit = account.figures.maps[m];
    fits.push_back({{"session", account.map_bases[m].session},
                    {"pose", account.map_bases[m].key},
                    {"end", account.map_ends[m].key},
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

Json join_of(const Account& account) {
  const RunFigures& figures = account.figures;
  const bool done = account.is_joined;
  return {{"status", done ? to_string(figures.join.status) : "not_run"},
          {"state", to_string(account.state)},
          {"start", value_if(account.schedule == Schedule::kBatch, to_string(account.start_values))},
          {"schedule", to_string(account.schedule)},
          {"path", path_of(figures)},
          {"method", to_string(account.method)},
          {"engine", to_string(account.engine)},
          {"iterations", value_if(done, figures.join.iterations)},
          {"factorisations", value_if(done, figures.join.factorisations)},
          {"turned", value_if(done, figures.turned)},
          {"chi2", value_if(done, figures.join.chi2)},
          {"course", value_if(done, course_of(figures.join))},
          {"dof", value_if(done, figures.join_dof)},
          {"maps", value_if(done, map_fits_of(account))},
          {"seconds", figures.seconds.join}};
}

Json polish_of(const Account& account) {
  if (!account.figures.polish) return {{"status", "not_run"}, {"iterations", nullptr}, {"chi2", nullptr}};
  const MinimiseResult& polish = *account.figures.polish;
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

Json certainty_of(const Account& account) {
  const auto deviations = account.deviations.value_or(Deviations{});
  const auto medians = [&](const Deviations::Median& of) {
    const bool known = account.deviations.has_value();
    return Json{{"in_map", value_if(known, of.in_map)}, {"relative", value_if(known, of.relative)}};
  };
  return {{"estimate", account.covariances ? Json(to_string(*account.covariances)) : Json()},
          {"median_deviation", {{"poses", medians(deviations.poses)}, {"features", medians(deviations.features)}}},
          {"nees",
           {{"poses", nees_of(account.consistency, &Consistency::poses)},
            {"features", nees_of(account.consistency, &Consistency::features)},
            {"joint", nees_of(account.consistency, &Consistency::joint)}}}};
}

Json seconds_of(const Account& account) {
  const RunSeconds& seconds = account.figures.seconds;
  return {{"read", account.read_seconds},   {"build", seconds.build},          {"join", seconds.join},
          {"recover", seconds.recover},     {"polish", seconds.polish},        {"covariances", seconds.covariances},
          {"write", account.write_seconds}, {"total", account.total_seconds()}};
}

}  // namespace

Json report_head(const Account& account) {
  Json json = {
      {"schema_version", kReportSchemaVersion}, {"version", kVersion}, {"command", account.command}, {"input", account.input}};
  json.update(input_of(account));
  return json;
}

std::string report(const Account& account) {
  const RunFigures& figures = account.figures;
  const auto& recovered = figures.recovered_chi2;
  Json json = report_head(account);
  json["local_maps"] = local_maps_of(account);
  json["join"] = join_of(account);
  json["recover"] = {{"chi2", value_if(recovered.has_value(), recovered.value_or(0.0))},
                     {"unrecovered", value_if(recovered.has_value(), figures.unrecovered)}};
  json["polish"] = polish_of(account);
  json["converged"] = value_if(account.is_joined, figures.converged());
  json["chi2"] = value_if(account.is_joined, figures.chi2);
  json["dof"] = value_if(account.is_joined, figures.dof);
  json["gauge"] = gauge_of(account);
  json["certainty"] = certainty_of(account);
  json["files"] = account.files;
  json["seconds"] = seconds_of(account);
  json["peak_memory_mb"] = peak_memory_mb();
  json["blas"] = account.is_joined ? Json(blas().name) : Json();
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Expected<void> write_report(const Account& account, const std::filesystem::path& path) {
  return write_file(path, report(account));
}

}  // namespace mapjoin::apps
