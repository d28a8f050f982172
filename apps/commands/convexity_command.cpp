// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin convexity`: how far from convex and from linear full SLAM and joining are (paper's Fig. 4, V and VI), as a table for
// people, JSON by docs/report.md and CSV for programs.

#include <fmt/format.h>

#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/report/report.hpp>
#include <apps/report/table.hpp>
#include <mapjoin/join/study/convexity.hpp>
#include <memory>
#include <optional>

namespace mapjoin::apps {
namespace {

struct ConvexityRequest : Options {
  ConvexityOptions convexity;
};

std::string pairs_in_words(const ConvexityOptions& options) {
  const std::string states =
      options.source == StateSource::kBox
          ? "positions uniform over the bounding box of the composed start, rotations uniform"
          : fmt::format("composed from measurements with {:g} times the errors they state", options.spread);
  return fmt::format("{} {}, {} values of lambda each, seed {}: {}", options.pairs,
                     options.to_best ? "of a random state and the best estimate" : "of random states", options.points,
                     options.seed, states);
}

/// chi2 of the best estimate of each problem, in words.
std::string best_in_words(const Convexity& found) {
  std::string words;
  for (std::size_t f = 0; f < found.size(); f += 2) {
    words += fmt::format("{}chi2 {:.6f} of {}, {:.6g} at the composed start", f == 0 ? "" : "; ", found[f].first_step.best_chi2,
                         problem_in_words(found[f].formulation), found[f].first_step.start_chi2);
  }
  return words;
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
  return {{"formulation", problem_in_words(figures.formulation)},
          {"state", figures.formulation.state},
          {"maps", figures.maps},
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
            {"share", figures.first_step.share()}}},
          {"pairs", pairs}};
}

/// The input, how the pairs of states were drawn, and a row per formulation.
std::string table_of(const Convexity& found, const Json& formulations, const ConvexityRequest& asked,
                     const RunReport& run_report) {
  Lines lines;
  add_input(run_report, lines);
  add_convention(run_report, lines);
  lines.add("pairs", pairs_in_words(asked.convexity));
  lines.add("best", best_in_words(found));
  lines.add("not convex",
            "share of lambda at which F is above its chord, (12), and by how much at the most, of the larger end");
  lines.add("bent down", "share of lambda at which the curvature of F is negative");
  lines.add("linear", "share of the rows that are linear in the state, and of the information that the estimate has from them");
  lines.add("one step", "of Gauss-Newton from the composed start: its share of the whole decrease");
  add_notes(run_report, lines);
  const bool is_cut_here = !may_hold_maps(asked.input);
  if (is_cut_here && found.back().maps == 0) lines.add("note", no_map_in_words(asked.run.split));
  ReportTable table{{{"", ""},
                     {"", "not convex (%)", 3, "/convexity/share_violated", 100.0},
                     {"", "by", 3, "/convexity/largest_violation"},
                     {"", "bent down (%)", 3, "/convexity/share_negative_curvature", 100.0},
                     {"", "linear rows (%)", 3, "/quadratic/share_of_rows", 100.0},
                     {"", "information (%)", 3, "/quadratic/share_of_information", 100.0},
                     {"", "one step (%)", 3, "/first_step/share", 100.0}},
                    {}};
  for (std::size_t f = 0; f < found.size(); ++f) {
    table.add(formulations[f]).cells.front() = to_string(found[f].formulation);
  }
  return lines.text() + "\n" + aligned(table);
}

/// CSV of F at every λ, with the header formulation,state,pair,lambda,F.
std::string csv_of(const Convexity& found) {
  std::string text = "formulation,state,pair,lambda,F\n";
  for (const FormulationFigures& figures : found) {
    for (std::size_t pair = 0; pair < figures.segments.size(); ++pair) {
      const std::vector<double>& values = figures.segments[pair].values;
      for (std::size_t k = 0; k < values.size(); ++k) {
        text += fmt::format("{},{},{},{},{}\n", problem_in_words(figures.formulation), to_string(figures.formulation.state),
                            pair + 1, static_cast<double>(k) / static_cast<double>(values.size() - 1), values[k]);
      }
    }
  }
  return text;
}

StudyOutput convexity_output(const Convexity& found, const ConvexityRequest& asked, const RunReport& run_report) {
  const ConvexityOptions& options = asked.convexity;
  Json report = report_head(run_report);
  report["states"] = options.source;
  report["spread"] = options.source == StateSource::kDrift ? std::optional(options.spread) : std::nullopt;
  report["to_best"] = options.to_best;
  report["points"] = options.points;
  report["seed"] = options.seed;
  report["tolerance"] = kCurvatureTolerance;
  report["formulations"] = Json::array();
  for (const FormulationFigures& figures : found) report["formulations"].push_back(json_of(figures));
  const std::string json = text_of(report);
  return {table_of(found, report["formulations"], asked, run_report),
          json,
          {{"curves.csv", csv_of(found)}, {"convexity.json", json}}};
}

ExitCode run_convexity(const ConvexityRequest& asked, const std::stop_token& stop) {
  CommandRun command_run("convexity", asked, stop);
  auto folder = output_folder(asked.output);
  command_run.prepare(report_of(asked));
  ConvexityOptions options = asked.convexity;
  options.split = asked.run.split;
  options.progress = command_run.progress().count("lines");
  const Convexity found = command_run.with_log_or_maps([&](const auto& data) {
    if constexpr (requires { data.log; }) {
      return convexity(data.log, split_along(data.log, data.segments), data.maps, options, stop).value();
    } else {
      return convexity(data, options, stop).value();
    }
  });
  command_run.check_interrupted();
  command_run.hand_over(convexity_output(found, asked, command_run.run_report), folder);
  return ExitCode::kDone;
}

void add_lines(Subcommand& command, ConvexityOptions& convexity) {
  command.group("Lines of states");
  command.choice("--states", convexity.source,
                 "Random states: positions uniform over the bounding box of the composed start and rotations uniform; or "
                 "composed, odometry and first observations, from measurements with errors of their own covariance");
  command.number<double>("--spread", convexity.spread, 1e-9, "X", "With drift: so many times those errors", 1e9);
  command.flag("--to-best", convexity.to_best, "From random states to the best estimate, not to other random states");
  command.number<std::size_t>("--pairs", convexity.pairs, 1, "N", "Pairs of states", 10'000);
  command.number<std::size_t>("--points", convexity.points, 3, "N", "Values of lambda from 0 to 1", 100'001);
  command.number<std::uint64_t>("--seed", convexity.seed, 0, "N", "The same seed gives the same states");
  command.only_with("--spread", "--states drift", [&convexity] { return convexity.source == StateSource::kDrift; });
}

}  // namespace

void declare_convexity(Subcommand& command) {
  command.examples(
      "  mapjoin convexity data/manhattan2d.g2o -o convexity\n"
      "  mapjoin convexity data/manhattan2d.g2o --states drift --spread 0.5 --to-best --pairs 20");
  const auto asked = std::make_shared<ConvexityRequest>();
  command.argument("LOG|MAPS", asked->input, kLogOrMaps);
  command.path("-o,--output", asked->output, "DIR", "Write curves.csv and convexity.json into this folder");
  add_lines(command, asked->convexity);
  add_splitting(command, *asked);
  add_reading(command, *asked);
  add_inflation(command, *asked);
  add_reporting(command, *asked);
  command.check([asked, &command] { return check_uncut(command, *asked); });
  command.check([asked] {
    return output_conflicts(inputs_of(*asked, "LOG|MAPS"), outputs_of_folder(*asked, {"curves.csv", "convexity.json"}));
  });
  command.act([asked](const std::stop_token& stop) { return run_convexity(*asked, stop); });
}

}  // namespace mapjoin::apps
