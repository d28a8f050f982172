// SPDX-License-Identifier: BSD-3-Clause
#include <apps/report/compare_report.hpp>
#include <apps/report/report.hpp>
#include <nlohmann/json.hpp>

namespace mapjoin::apps {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const ErrorSummary& errors) {
  return {{"count", errors.count}, {"rms", errors.rms}, {"max", errors.max}};
}
Json json_of(const PoseErrorSummary& errors) {
  return {{"translation", json_of(errors.translation)}, {"rotation", json_of(errors.rotation)}};
}
Json json_of(const MapDifference& difference) {
  return {{"poses", json_of(difference.poses)}, {"features", json_of(difference.features)}};
}

Json json_of(const std::vector<std::size_t>& spans, const std::vector<PoseErrorSummary>& errors) {
  Json all = Json::array();
  for (std::size_t k = 0; k < spans.size(); ++k) {
    Json one = {{"span", spans[k]}};
    one.update(json_of(errors[k]));
    all.push_back(one);
  }
  return all;
}

Json json_of(const std::vector<std::size_t>& spans, const EstimateFigures& estimate) {
  Json from_best = json_of(estimate.from_best);
  from_best["relative_poses"] = json_of(spans, estimate.best_spans);
  Json from_truth;
  if (estimate.from_truth) {
    from_truth = {{"ate", json_of(estimate.from_truth->absolute)}, {"rpe", json_of(spans, estimate.from_truth->spans)}};
  }
  return {{"chi2", estimate.chi2}, {"from_best", from_best}, {"from_truth", from_truth}};
}

Json effort_of(const CaseFigures& figures) {
  const Effort& effort = figures.effort;
  return {{"seconds", effort.seconds},
          {"cpu_seconds", effort.cpu_seconds},
          {"memory_bytes", effort.memory ? Json(*effort.memory) : Json()}};
}

Json json_of(const std::vector<std::size_t>& spans, const CaseFigures& figures) {
  const ComparedCase& way = figures.way;
  Json json = {{"formulation", problem_in_words(way.formulation())},
               {"steps_per_map", way.poses_per_map},
               {"state", to_string(way.state)},
               {"schedule", schedule_in_words(way)},
               {"result", result_in_words(figures)},
               {"reaches_best", figures.reaches_best}};
  const RunFigures& run = figures.run;
  const bool known = figures.has_map();
  json["local_maps"] = known ? Json(run.local_maps) : Json();
  json["join"] = known ? Json{{"status", to_string(run.join.status)},
                              {"iterations", figures.join_iterations()},
                              {"chi2", run.join.chi2},
                              {"dof", run.join_dof}}
                       : Json();
  json["polish_iterations"] = known ? Json(figures.polish_iterations()) : Json();
  json["system_bytes"] = known ? Json(run.joint_bytes) : Json();
  json["joined"] = known ? json_of(spans, figures.joined) : Json();
  json["polished"] = known ? json_of(spans, figures.polished) : Json();
  json["effort"] = effort_of(figures);
  return json;
}

Json json_of(const OtherWeights& other) {
  const bool known = other.failure.empty();
  return {{"covariance", to_string(other.covariance)},
          {"failure", known ? Json() : Json(other.failure)},
          {"chi2", known ? Json(other.chi2) : Json()},
          {"from_best", known ? json_of(other.from_best) : Json()}};
}

}  // namespace

std::string compare_report(const RunReport& run_report, const ComparisonFigures& comparison, const OtherWeights& other) {
  Json json = report_head(run_report);
  json["dof"] = comparison.cases[comparison.best].run.dof;
  json["best"] = comparison.best;
  json["spans"] = comparison.spans;
  json["cases"] = Json::array();
  for (const CaseFigures& figures : comparison.cases) json["cases"].push_back(json_of(comparison.spans, figures));
  json["other_weights"] = json_of(other);
  return text_of(json);
}

}  // namespace mapjoin::apps
