// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/console.hpp>
#include <apps/report/basin_report.hpp>
#include <apps/report/report.hpp>
#include <apps/report/table.hpp>
#include <cmath>
#include <mapjoin/measure/median.hpp>
#include <nlohmann/json.hpp>

namespace mapjoin::apps {
namespace {

using Json = nlohmann::ordered_json;

const char* ending(const BasinRun& run) {
  if (run.is_at_optimum) return "optimum";
  return run.failure ? "failed" : "elsewhere";
}

/// The median of the iterations of the runs that end at the optimum, or else of all.
int typical_iterations(const BasinCell& cell) {
  std::vector<int> iterations;
  for (const BasinRun& run : cell.runs) {
    if (run.is_at_optimum || cell.hits() == 0) iterations.push_back(run.iterations);
  }
  return median(std::move(iterations));
}

/// What the runs that miss fell into: their chi2, from the least to the largest.
std::string misses_in_words(const BasinCell& cell) {
  std::vector<double> chi2;
  for (const BasinRun& run : cell.runs) {
    if (!run.is_at_optimum && std::isfinite(run.chi2)) chi2.push_back(run.chi2);
  }
  if (chi2.empty()) return cell.hits() == cell.runs.size() ? "" : "no map";
  const auto [least, most] = std::minmax_element(chi2.begin(), chi2.end());
  return *least == *most ? fmt::format("{:.4g}", *least) : fmt::format("{:.4g} to {:.4g}", *least, *most);
}

/// "yes (12)", "no (200): 2.814e+05", "17 of 20 (9): 3.1e+04 to 1.2e+09"; iterations in parentheses.
std::string cell_in_words(const BasinCell& cell) {
  std::string rate = cell.hits() == 1 ? "yes" : "no";
  if (cell.start == Start::kRandom) rate = fmt::format("{} of {}", cell.hits(), cell.runs.size());
  const std::string misses = misses_in_words(cell);
  return fmt::format("{} ({}){}", rate, typical_iterations(cell), misses.empty() ? "" : ": " + misses);
}

/// The local maps of a cell, as --poses-per-map and its like name them: "20", "auto", "10 m", "15 features"; empty for full
/// SLAM and for maps that were cut before.
std::string split_in_words(const BasinCell& cell) {
  if (!cell.split) return "";
  switch (cell.split->rule) {
    case SplitRule::kAuto:
      return "auto";
    case SplitRule::kPoses:
      return fmt::format("{:g}", cell.split->amount);
    case SplitRule::kDistance:
      return fmt::format("{:g} m", cell.split->amount);
    case SplitRule::kFeatures:
      return fmt::format("{:g} features", cell.split->amount);
  }
  return "";
}

const char* problem(const BasinCell& cell) {
  return cell.formulation.is_joining ? "joining" : "full_slam";
}

Json json_of(const BasinCell& cell, std::size_t k) {
  const BasinRun& run = cell.runs[k];
  return {{"seed", cell.start == Start::kRandom ? Json(BasinCell::seed_of(k)) : Json()},
          {"ends", ending(run)},
          {"chi2", std::isfinite(run.chi2) ? Json(run.chi2) : Json()},
          {"iterations", run.iterations},
          {"status", run.failure ? Json() : Json(to_string(run.status))},
          {"failure", run.failure ? Json(*run.failure) : Json()}};
}

Json json_of(const BasinCell& cell) {
  Json runs = Json::array();
  for (std::size_t k = 0; k < cell.runs.size(); ++k) runs.push_back(json_of(cell, k));
  return {{"covariance", to_string(cell.covariance)},
          {"problem", problem(cell)},
          {"state", to_string(cell.formulation.state)},
          {"local_maps", cell.split ? Json(split_in_words(cell)) : Json()},
          {"method", to_string(cell.method)},
          {"start", to_string(cell.start)},
          {"hits", cell.hits()},
          {"runs", runs}};
}

}  // namespace

std::string basin_table(const Basin& basin, const RunReport& run_report) {
  Lines lines;
  lines.add("input", fmt::format("{}: {}", run_report.input, counts_in_words(run_report)));
  for (std::size_t c = 0; c < basin.covariances.size(); ++c) {
    lines.add(c == 0 ? "optimum" : "", fmt::format("chi2 {:.6f} with {} covariances, the best known", basin.best_chi2[c],
                                                   to_string(basin.covariances[c])));
  }
  lines.add("convention", conventions_in_words(run_report.conventions, run_report.dimension));
  lines.add("cells", "whether, or how often, the optimum is reached (iterations): chi2 of what the others fell into");
  Table table{{{"covariance", "covariance"},
               {"formulation", "formulation"},
               {"local_maps", "maps of"},
               {"method", "method"},
               {"composed", "composed"},
               {"zero", "zero"},
               {"random", "random"}},
              {}};
  for (const BasinCell& cell : basin.cells) {
    if (cell.start == kBasinStarts.front()) {
      table.rows.push_back(
          {{to_string(cell.covariance), to_string(cell.formulation), split_in_words(cell), to_string(cell.method)}});
    }
    table.rows.back().cells.emplace_back(cell_in_words(cell));
  }
  return lines.text() + "\n" + aligned(table);
}

std::string basin_csv(const Basin& basin) {
  Table table;
  for (const char* key :
       {"covariance", "problem", "state", "local_maps", "method", "start", "seed", "ends", "chi2", "iterations", "status"}) {
    table.columns.push_back({key, key});
  }
  for (const BasinCell& cell : basin.cells) {
    for (std::size_t k = 0; k < cell.runs.size(); ++k) {
      const BasinRun& run = cell.runs[k];
      table.rows.push_back({{to_string(cell.covariance), problem(cell), to_string(cell.formulation.state), split_in_words(cell),
                             to_string(cell.method), to_string(cell.start),
                             cell.start == Start::kRandom ? Cell(static_cast<std::int64_t>(BasinCell::seed_of(k))) : Cell(),
                             ending(run), std::isfinite(run.chi2) ? Cell(run.chi2) : Cell(), std::int64_t{run.iterations},
                             run.failure ? Cell() : Cell(to_string(run.status))}});
    }
  }
  return csv(table);
}

std::string basin_json(const Basin& basin, const RunReport& run_report) {
  Json best;
  for (std::size_t c = 0; c < basin.covariances.size(); ++c) best[to_string(basin.covariances[c])] = basin.best_chi2[c];
  Json cells = Json::array();
  for (const BasinCell& cell : basin.cells) cells.push_back(json_of(cell));
  Json json = report_head(run_report);
  json["best_chi2"] = best;
  json["cells"] = cells;
  json["seconds"] = run_report.total_seconds();
  return text_of(json);
}

}  // namespace mapjoin::apps
