// SPDX-License-Identifier: BSD-3-Clause
#include "speed_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <apps/report/table.hpp>

namespace mapjoin::bench {
namespace {

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::vector<double> all(const Runs& runs, Figure figure) {
  std::vector<double> values;
  for (const Trial& trial : runs.trials) values.push_back(trial.*figure);
  return values;
}

/// The median ratio of a figure of `a` to that of `b` in the same round.
double median_ratio(const Runs& a, const Runs& b, Figure figure) {
  std::vector<double> ratios;
  for (std::size_t round = 0; round < std::min(a.trials.size(), b.trials.size()); ++round) {
    ratios.push_back(a.trials[round].*figure / b.trials[round].*figure);
  }
  return median(ratios);
}

/// The end of the first run: "optimum", its chi2, or why there is none.
std::string end_of(const Runs& runs, double optimum) {
  const Trial& trial = runs.trials.front();
  if (!trial.chi2) return trial.failure;
  return *trial.chi2 <= optimum * (1.0 + kAsGood) ? "optimum" : fmt::format("chi2 {:.6g}", *trial.chi2);
}

/// The table in Markdown.
std::string lines_of(const apps::ReportTable& table) {
  std::string head = "|";
  std::string rule = "|";
  for (const apps::Column& column : table.columns) {
    head += fmt::format(" {} |", column.heading);
    rule += "---|";
  }
  std::string lines = head + "\n" + rule + "\n";
  for (const apps::Row& row : table.rows) {
    lines += "|";
    for (std::size_t c = 0; c < row.cells.size(); ++c) lines += fmt::format(" {} |", shown(row.cells[c], table.columns[c]));
    lines += "\n";
  }
  return lines;
}

/// The row of a program. The start-up of the limit is not part of it, so that it has no wall time.
apps::Row row_of(const Runs& runs, const Result& result) {
  const Runs& first = result.runs.front();
  const auto if_program = [&](double figure) {
    return runs.program.kind == ProgramKind::kLimit ? apps::Cell() : apps::Cell(figure);
  };
  return {{result.data.name, pose_count(result), runs.program.name, median_of(runs, &Trial::cpu_seconds),
           if_program(median_of(runs, &Trial::wall_seconds)), median_of(runs, &Trial::memory_mb),
           median_ratio(first, runs, &Trial::cpu_seconds), if_program(median_ratio(runs, first, &Trial::wall_seconds)),
           end_of(runs, result.optimum)}};
}

nlohmann::json json_of(const Runs& runs, const Result& result) {
  const Runs& first = result.runs.front();
  const auto& last = runs.trials.back().said;
  const bool has_stages = last.is_object() && last.contains("seconds");
  nlohmann::json json = {{"program", runs.program.name},
                         {"end", end_of(runs, result.optimum)},
                         {"cpu_seconds", all(runs, &Trial::cpu_seconds)},
                         {"wall_seconds", all(runs, &Trial::wall_seconds)},
                         {"memory_mb", all(runs, &Trial::memory_mb)},
                         {"median_cpu_seconds", median_of(runs, &Trial::cpu_seconds)},
                         {"mapjoin_by_own_cpu", median_ratio(first, runs, &Trial::cpu_seconds)},
                         {"wall_by_mapjoin", median_ratio(runs, first, &Trial::wall_seconds)},
                         {"stage_seconds", has_stages ? last.at("seconds") : nlohmann::json()}};
  const auto& chi2 = runs.trials.front().chi2;
  json["chi2"] = chi2 ? nlohmann::json(*chi2) : nlohmann::json();
  return json;
}

}  // namespace

std::int64_t pose_count(const Result& result) {
  for (const Runs& runs : result.runs) {
    const auto& said = runs.trials.front().said;
    if (said.is_object() && said.contains("poses")) return said.at("poses").get<std::int64_t>();
  }
  return 0;
}

double median_of(const Runs& runs, Figure figure) {
  return median(all(runs, figure));
}

std::string table_of(const std::vector<Result>& results) {
  apps::ReportTable table{{{"data", "data"},
                           {"poses", "poses"},
                           {"program", "program"},
                           {"cpu", "CPU (s)", 3},
                           {"wall", "wall (s)", 3},
                           {"memory", "memory (MB)", 4},
                           {"mapjoin_by_own_cpu", "mapjoin's CPU / its own", 3},
                           {"wall_by_mapjoin", "its wall / mapjoin's", 3},
                           {"end", "ends at"}},
                          {}};
  for (const Result& result : results) {
    for (const Runs& runs : result.runs) table.rows.push_back(row_of(runs, result));
  }
  return lines_of(table);
}

nlohmann::json json_of(const std::vector<Result>& results) {
  nlohmann::json json = nlohmann::json::array();
  for (const Result& result : results) {
    nlohmann::json programs = nlohmann::json::array();
    for (const Runs& runs : result.runs) programs.push_back(json_of(runs, result));
    json.push_back({{"data", result.data.name},
                    {"file", result.data.source.string()},
                    {"sha256", result.sha256},
                    {"poses", pose_count(result)},
                    {"optimum", result.optimum},
                    {"programs", programs}});
  }
  return json;
}

}  // namespace mapjoin::bench
