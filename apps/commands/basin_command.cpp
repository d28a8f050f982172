// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin basin`: the experiment of the paper's Table I, with its results as a table for people, JSON by docs/report.md and
// CSV for programs.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/report/report.hpp>
#include <apps/report/table.hpp>
#include <cmath>
#include <mapjoin/join/study/basin.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <memory>
#include <optional>

namespace mapjoin::apps {
namespace {

struct BasinRequest : Options {
  BasinOptions basin;
};

/// The median of the iterations of the runs that end at the optimum, or of all if none does.
int typical_iterations(const BasinCell& cell) {
  std::vector<int> iterations;
  for (const BasinRun& run : cell.runs) {
    if (run.is_at_optimum || cell.hits() == 0) iterations.push_back(run.iterations);
  }
  return median(std::move(iterations));
}

/// The least and the largest chi2 of the runs that miss the optimum.
std::string misses_in_words(const BasinCell& cell) {
  std::vector<double> chi2;
  for (const BasinRun& run : cell.runs) {
    if (!run.is_at_optimum && std::isfinite(run.chi2)) chi2.push_back(run.chi2);
  }
  if (chi2.empty()) return cell.hits() == cell.runs.size() ? "" : ": no map";
  const auto [least, most] = std::minmax_element(chi2.begin(), chi2.end());
  return *least == *most ? fmt::format(": {:.4g}", *least) : fmt::format(": {:.4g} to {:.4g}", *least, *most);
}

/// A cell in words, with iterations in parentheses: "yes (12)", "no (200): 2.814e+05", "17 of 20 (9): 3.1e+04 to 1.2e+09".
std::string cell_in_words(const BasinCell& cell) {
  std::string rate = cell.hits() == 1 ? "yes" : "no";
  if (cell.start == Start::kRandom) rate = fmt::format("{} of {}", cell.hits(), cell.runs.size());
  return fmt::format("{} ({}){}", rate, typical_iterations(cell), misses_in_words(cell));
}

/// The splitting of a cell; nullopt for full SLAM and for maps that were cut before.
std::optional<std::string> split_in_words(const BasinCell& cell) {
  return cell.split ? std::optional(in_words(*cell.split)) : std::nullopt;
}

Json json_of(const BasinCell& cell, std::size_t k) {
  const BasinRun& run = cell.runs[k];
  return {{"seed", cell.start == Start::kRandom ? std::optional(BasinCell::seed_of(k)) : std::nullopt},
          {"ends", run.is_at_optimum ? "optimum"
                   : run.failure     ? "failed"
                                     : "elsewhere"},
          {"chi2", run.chi2},
          {"iterations", run.iterations},
          {"status", run.failure ? std::nullopt : std::optional(run.status)},
          {"failure", run.failure}};
}

Json json_of(const BasinCell& cell) {
  Json runs = Json::array();
  for (std::size_t k = 0; k < cell.runs.size(); ++k) runs.push_back(json_of(cell, k));
  return {{"covariance", cell.covariance},
          {"problem", cell.formulation.is_joining ? "joining" : "full_slam"},
          {"state", cell.formulation.state},
          {"local_maps", split_in_words(cell)},
          {"maps", cell.maps},
          {"method", cell.method},
          {"start", cell.start},
          {"hits", cell.hits()},
          {"runs", runs}};
}

/// The splits that cut the log into no local map.
std::vector<SplitOptions> splits_without_maps(const Basin& basin) {
  std::vector<SplitOptions> splits;
  for (const BasinCell& cell : basin.cells) {
    if (cell.split && cell.maps == 0 && std::ranges::find(splits, *cell.split) == splits.end()) splits.push_back(*cell.split);
  }
  return splits;
}

/// The input and the best chi2 known; then a row per covariance, formulation, split and method and a column per start, as in
/// the paper's Table I.
std::string table_of(const Basin& basin, const RunReport& run_report) {
  Lines lines;
  add_input(run_report, lines);
  for (std::size_t c = 0; c < basin.covariances.size(); ++c) {
    lines.add(c == 0 ? "optimum" : "", fmt::format("chi2 {:.6f} with {} covariances, the best known", basin.best_chi2[c],
                                                   to_string(basin.covariances[c])));
  }
  add_convention(run_report, lines);
  lines.add("cells", "whether, or how often, the optimum is reached (iterations): chi2 of what the others fell into");
  add_notes(run_report, lines);
  for (const SplitOptions& split : splits_without_maps(basin)) lines.add("note", no_map_in_words(split));
  ReportTable table;
  for (const char* heading : {"covariance", "formulation", "maps of", "method", "composed", "zero", "random"}) {
    table.columns.push_back({heading, heading});
  }
  for (const BasinCell& cell : basin.cells) {
    if (cell.start == kBasinStarts.front()) {
      table.rows.push_back({{cell.covariance, to_string(cell.formulation), split_in_words(cell).value_or(""), cell.method}});
    }
    table.rows.back().cells.emplace_back(cell_in_words(cell));
  }
  return lines.text() + "\n" + aligned(table);
}

/// CSV with a row per solve, from the cells of the report.
std::string csv_of(const Json& cells) {
  ReportTable table;
  for (const char* key :
       {"covariance", "problem", "state", "local_maps", "method", "start", "seed", "ends", "chi2", "iterations", "status"}) {
    table.columns.push_back({key, key});
  }
  for (Json solve : cells) {
    for (const Json& run : Json(solve["runs"])) {
      solve.update(run);
      table.add(solve);
    }
  }
  return csv(table);
}

StudyOutput basin_output(const Basin& basin, const RunReport& run_report) {
  Json report = report_head(run_report);
  for (std::size_t c = 0; c < basin.covariances.size(); ++c) {
    report["best_chi2"][to_string(basin.covariances[c])] = basin.best_chi2[c];
  }
  report["cells"] = Json::array();
  for (const BasinCell& cell : basin.cells) report["cells"].push_back(json_of(cell));
  report["seconds"] = run_report.total_seconds();
  const std::string json = text_of(report);
  return {table_of(basin, run_report), json, {{"basin.csv", csv_of(report["cells"])}, {"basin.json", json}}};
}

ExitCode run_basin(const BasinRequest& asked, const std::stop_token& stop) {
  CommandRun command_run("basin", asked, stop);
  auto folder = output_folder(asked.output);
  command_run.prepare(report_of(asked));
  BasinOptions options = asked.basin;
  options.progress = command_run.progress().count("solves");
  const Basin found = command_run.with_log_or_maps([&](const auto& data) {
    if constexpr (requires { data.log; }) {
      return basin(data.log, split_along(data.log, data.segments), options, stop).value();
    } else {
      return basin(data, options, stop).value();
    }
  });
  command_run.check_interrupted();
  command_run.hand_over(basin_output(found, command_run.run_report), folder);
  return ExitCode::kDone;
}

}  // namespace

void declare_basin(Subcommand& command) {
  command.examples(
      "  mapjoin basin data/manhattan2d.g2o --seeds 3\n"
      "  mapjoin basin data/manhattan2d.g2o --poses-per-map 20,60 --seeds 2 -o basin");
  const auto asked = std::make_shared<BasinRequest>();
  BasinOptions& basin = asked->basin;
  command.argument("LOG|MAPS", asked->input, kLogOrMaps);
  command.path("-o,--output", asked->output, "DIR", "Write basin.csv and basin.json into this folder");
  command.group("Experiment");
  command.list("--poses-per-map", "N|auto,...", "Lengths of the local maps to join, of a log [auto]", basin.splits,
               split_by_poses, "not auto, nor whole numbers from 1 on with commas between them");
  command.number("--seeds", basin.seeds, 1, "N", "Random starts per cell");
  command.number("--max-iterations", basin.max_iterations, 1, "N",
                 "At most so many steps of every solve, where gradual of its last one");
  add_reading(command, *asked);
  add_inflation(command, *asked);
  add_reporting(command, *asked);
  command.check([asked, &command] { return check_uncut(command, *asked); });
  command.check([asked] {
    return output_conflicts(inputs_of(*asked, "LOG|MAPS"), outputs_of_folder(*asked, {"basin.csv", "basin.json"}));
  });
  command.act([asked](const std::stop_token& stop) { return run_basin(*asked, stop); });
}

}  // namespace mapjoin::apps
