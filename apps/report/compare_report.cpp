// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/report/report.hpp>
#include <apps/report/study_reports.hpp>

namespace mapjoin {

static void to_json(apps::Json& json, const ErrorSummary& errors) {
  json = {{"count", errors.count}};
  json.update(apps::if_known(errors.count > 0, {{"rms", errors.rms}, {"max", errors.max}}));
}
static void to_json(apps::Json& json, const PoseErrorSummary& errors) {
  json = {{"translation", errors.translation}, {"rotation", errors.rotation}};
}
static void to_json(apps::Json& json, const MapDifference& difference) {
  json = {{"poses", difference.poses}, {"features", difference.features}};
}

namespace apps {
namespace {

Json over_spans(const std::vector<std::size_t>& spans, const std::vector<PoseErrorSummary>& errors) {
  Json all = Json::array();
  for (std::size_t k = 0; k < spans.size(); ++k) {
    all.push_back({{"span", spans[k]}});
    all.back().update(Json(errors[k]));
  }
  return all;
}

Json json_of(const std::vector<std::size_t>& spans, const EstimateFigures& estimate) {
  Json json = {{"chi2", estimate.chi2}, {"from_best", estimate.from_best}, {"from_truth", nullptr}};
  json["from_best"]["relative_poses"] = over_spans(spans, estimate.best_spans);
  if (estimate.from_truth) {
    json["from_truth"] = {{"ate", estimate.from_truth->absolute}, {"rpe", over_spans(spans, estimate.from_truth->spans)}};
  }
  return json;
}

Json json_of(const std::vector<std::size_t>& spans, const CaseFigures& figures) {
  const ComparedCase& way = figures.way;
  const RunFigures& run = figures.run;
  Json json = {{"formulation", problem_in_words(way.formulation())},
               {"steps_per_map", way.poses_per_map},
               {"state", way.state},
               {"schedule", schedule_in_words(way)},
               {"result", result_in_words(figures)},
               {"reaches_best", figures.reaches_best}};
  json.update(if_known(figures.has_map(), {{"local_maps", run.local_maps},
                                           {"join",
                                            {{"status", run.join.status},
                                             {"iterations", figures.join_iterations()},
                                             {"chi2", run.join.chi2},
                                             {"dof", run.join_dof}}},
                                           {"polish_iterations", figures.polish_iterations()},
                                           {"system_bytes", run.joint_bytes},
                                           {"joined", nullptr},
                                           {"polished", nullptr}}));
  if (figures.has_map()) {
    json["joined"] = json_of(spans, figures.joined);
    json["polished"] = json_of(spans, figures.polished);
  }
  json["effort"] = {{"seconds", figures.effort.seconds},
                    {"cpu_seconds", figures.effort.cpu_seconds},
                    {"memory_bytes", figures.effort.memory}};
  return json;
}

template <int Dim>
Json json_of(const RunReport& run_report, const ComparisonFigures& comparison, const OtherWeights<Dim>& other) {
  Json json = report_head(run_report);
  json["dof"] = comparison.cases[comparison.best].run.dof;
  json["best"] = comparison.best;
  json["spans"] = comparison.spans;
  json["cases"] = Json::array();
  for (const CaseFigures& figures : comparison.cases) json["cases"].push_back(json_of(comparison.spans, figures));
  const bool is_known = other.failure.empty();
  json["other_weights"] = {{"covariance", other.covariance}, {"failure", is_known ? Json() : Json(other.failure)}};
  json["other_weights"].update(if_known(is_known, {{"chi2", other.chi2}, {"from_best", other.from_best}}));
  return json;
}

template <int Dim>
std::string in_words(const OtherWeights<Dim>& other) {
  if (!other.failure.empty()) return other.failure;
  const MapDifference& apart = other.from_best;
  const std::string features = apart.features.count > 0 ? fmt::format(", features {:.2g} m", apart.features.rms) : "";
  return fmt::format("chi2 {:.10g}; from the best map: poses {:.2g} m{} (RMS)", other.chi2, apart.poses.translation.rms,
                     features);
}

template <int Dim>
std::string summary_of(const RunReport& run_report, const ComparisonFigures& comparison, const OtherWeights<Dim>& other,
                       const std::vector<NamedTable>& tables) {
  const CaseFigures& best = comparison.cases[comparison.best];
  Lines lines;
  add_input(run_report, lines);
  add_convention(run_report, lines);
  lines.add("best", fmt::format("chi2 {:.10g}, dof {}", best.polished.chi2, best.run.dof));
  lines.add(to_string(other.covariance), in_words(other));
  for (const std::string& file : run_report.files) lines.add("written", file);
  std::string text = lines.text();
  for (const NamedTable& named : tables) text += fmt::format("\n{}\n{}", named.name, aligned(named.table));
  return text;
}

}  // namespace

template <int Dim>
StudyOutput compare_output(const Comparison<Dim>& comparison, const OtherWeights<Dim>& other, const Log<Dim>& log,
                           const RunReport& run_report) {
  const Json report = json_of(run_report, comparison, other);
  const std::vector<NamedTable> tables = tables_of(comparison, report["cases"]);
  StudyOutput output{summary_of(run_report, comparison, other, tables), text_of(report), {}};
  if (run_report.files.empty()) return output;
  output.files = {{"compare.json", output.json},
                  {"compare.csv", csv(whole_table(comparison, report["cases"]))},
                  {"compare.html", compare_page(run_report, comparison, other, tables, log.sessions)}};
  return output;
}

template StudyOutput compare_output(const Comparison<2>&, const OtherWeights<2>&, const Log<2>&, const RunReport&);
template StudyOutput compare_output(const Comparison<3>&, const OtherWeights<3>&, const Log<3>&, const RunReport&);

}  // namespace apps
}  // namespace mapjoin
