// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/console.hpp>
#include <apps/report/convexity_report.hpp>
#include <apps/report/report.hpp>
#include <apps/report/table.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace mapjoin::apps {
namespace {

using Json = nlohmann::ordered_json;

std::string pairs_in_words(const ConvexityOptions& options) {
  const std::string states =
      options.source == StateSource::kBox
          ? "positions uniform over the bounding box of the composed start, rotations uniform"
          : fmt::format("composed from measurements with {:g} times the errors they state", options.spread);
  return fmt::format("{} {}, {} values of lambda each, seed {}: {}", options.pairs,
                     options.to_best ? "of a random state and the best estimate" : "of random states", options.points,
                     options.seed, states);
}

/// chi2 of the best estimates, a word for each problem.
std::string best_in_words(const Convexity& found) {
  std::string words;
  for (std::size_t f = 0; f < found.size(); f += 2) {
    words += fmt::format("{}chi2 {:.6f} of {}, {:.6g} at the composed start", f == 0 ? "" : "; ", found[f].first_step.best_chi2,
                         problem_in_words(found[f].formulation), found[f].first_step.start_chi2);
  }
  return words;
}

Row row_of(const FormulationFigures& figures) {
  const CurvatureFigures& curvature = figures.curvature;
  const auto step = figures.first_step.share();
  return {{to_string(figures.formulation), 100.0 * curvature.share_violated(),
           curvature.violations == 0 ? Cell() : Cell(curvature.largest_violation), 100.0 * curvature.share_negative(),
           100.0 * figures.quadratic.of_rows(), 100.0 * figures.quadratic.information, step ? Cell(100.0 * *step) : Cell()}};
}

Json json_of(const CurvatureFigures& curvature) {
  return {{"share_violated", curvature.share_violated()},
          {"largest_violation", curvature.largest_violation},
          {"share_negative_curvature", curvature.share_negative()}};
}

Json json_of(const FormulationFigures& figures) {
  Json pairs = Json::array();
  for (const LineOfStates& line : figures.segments) {
    Json pair = json_of(line.curvature);
    pair["F_Y"] = line.values.front();
    pair["F_X"] = line.values.back();
    pairs.push_back(std::move(pair));
  }
  const auto share = figures.first_step.share();
  return {{"formulation", problem_in_words(figures.formulation)},
          {"state", to_string(figures.formulation.state)},
          {"convexity", json_of(figures.curvature)},
          {"quadratic",
           {{"rows", figures.quadratic.rows},
            {"quadratic_rows", figures.quadratic.quadratic_rows},
            {"share_of_rows", figures.quadratic.of_rows()},
            {"share_of_information", figures.quadratic.information}}},
          {"first_step",
           {{"start_chi2", figures.first_step.start_chi2},
            {"chi2", figures.first_step.chi2},
            {"best_chi2", figures.first_step.best_chi2},
            {"share", share ? Json(*share) : Json()}}},
          {"pairs", pairs}};
}

}  // namespace

std::string convexity_table(const Convexity& found, const ConvexityOptions& options, const RunReport& run_report) {
  Lines lines;
  lines.add("input", fmt::format("{}: {}", run_report.input, counts_in_words(run_report)));
  lines.add("convention", conventions_in_words(run_report.conventions, run_report.dimension));
  lines.add("pairs", pairs_in_words(options));
  lines.add("best", best_in_words(found));
  lines.add("not convex",
            "share of lambda at which F is above its chord, (12), and by how much at the most, of the larger end");
  lines.add("bent down", "share of lambda at which the curvature of F is negative");
  lines.add("linear", "share of the rows that are linear in the state, and of the information that the estimate has from them");
  lines.add("one step", "of Gauss-Newton from the composed start: its share of the whole decrease");
  Table table{{{"", ""},
               {"", "not convex (%)", 3},
               {"", "by", 3},
               {"", "bent down (%)", 3},
               {"", "linear rows (%)", 3},
               {"", "information (%)", 3},
               {"", "one step (%)", 3}},
              {}};
  for (const FormulationFigures& figures : found) table.rows.push_back(row_of(figures));
  return lines.text() + "\n" + aligned(table);
}

std::string convexity_csv(const Convexity& found) {
  Table table;
  for (const char* key : {"formulation", "state", "pair", "lambda", "F"}) table.columns.push_back({key, key});
  for (const FormulationFigures& figures : found) {
    for (std::size_t pair = 0; pair < figures.segments.size(); ++pair) {
      const std::vector<double>& values = figures.segments[pair].values;
      for (std::size_t k = 0; k < values.size(); ++k) {
        const double lambda = static_cast<double>(k) / static_cast<double>(values.size() - 1);
        table.rows.push_back({{problem_in_words(figures.formulation), to_string(figures.formulation.state),
                               static_cast<std::int64_t>(pair + 1), lambda, values[k]}});
      }
    }
  }
  return csv(table);
}

std::string convexity_json(const Convexity& found, const ConvexityOptions& options, const RunReport& run_report) {
  Json formulations = Json::array();
  for (const FormulationFigures& figures : found) formulations.push_back(json_of(figures));
  Json json = report_head(run_report);
  json["states"] = to_string(options.source);
  json["spread"] = options.source == StateSource::kDrift ? Json(options.spread) : Json();
  json["to_best"] = options.to_best;
  json["points"] = options.points;
  json["seed"] = options.seed;
  json["tolerance"] = kCurvatureTolerance;
  json["formulations"] = std::move(formulations);
  return text_of(json);
}

}  // namespace mapjoin::apps
