// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/report/compare_report.hpp>
#include <apps/report/report.hpp>
#include <cmath>
#include <numeric>

namespace mapjoin::apps {
namespace {

constexpr double kShownAlike = 1e-4;   // relative difference of chi2 that people are not shown
constexpr std::size_t kForPeople = 3;  // every third of 1, 2, 5, 10, …: the powers of ten

using Columns = std::vector<Column>;

const Columns kCost = {{"join_chi2", "chi2 of the join", 10, "/join/chi2"},
                       {"joined_chi2", "chi2 before polishing", 10, "/joined/chi2"},
                       {"polished_chi2", "chi2 polished", 10, "/polished/chi2"},
                       {"join_iterations", "join iter.", 4, "/join/iterations"},
                       {"polish_iterations", "polish iter."},
                       {"seconds", "time (s)", 3, "/effort/seconds"},
                       {"cpu_seconds", "CPU (s)", 3, "/effort/cpu_seconds"},
                       {"system_mb", "system (MB)", 3, "/system_bytes", 1e-6},
                       {"memory_mb", "memory (MB)", 3, "/effort/memory_bytes", 1e-6}};

/// A kind of errors, with its place in a report.
struct Part {
  std::string name, unit, path;
};
const Part kPoses{"poses", "m", "poses/translation"};
const Part kTurns{"turns", "rad", "poses/rotation"};
const Part kFeatures{"features", "m", "features"};

/// Adds the distances of the joined or the polished estimate (`side`) from the best map, as they stand.
void add_distances(const std::string& side, const std::vector<Part>& parts, Columns& columns) {
  for (const auto& [name, unit, path] : parts) {
    for (const std::string word : {"max", "rms"}) {
      columns.push_back({fmt::format("{}_{}_{}_{}", side, name, word, unit),
                         fmt::format("{} {} {} ({})", side, name, word, unit), 2,
                         fmt::format("/{}/from_best/{}/{}", side, path, word)});
    }
  }
}

/// Adds the relative errors over every span, or over one in `every`.
void add_spans(const std::string& side, const std::vector<std::size_t>& spans, std::size_t every, Columns& columns) {
  for (std::size_t k = 0; k < spans.size(); k += every) {
    columns.push_back({fmt::format("{}_relative_{}_m", side, spans[k]), fmt::format("{} over {} (m)", side, spans[k]), 2,
                       fmt::format("/{}/from_best/relative_poses/{}/translation/rms", side, k)});
  }
}

void add_truth(const std::string& side, const std::vector<std::size_t>& spans, std::size_t every, Columns& columns) {
  columns.push_back({side + "_ate_m", side + " ATE (m)", 4, fmt::format("/{}/from_truth/ate/translation/rms", side)});
  for (std::size_t k = 0; k < spans.size(); k += every) {
    columns.push_back({fmt::format("{}_rpe_{}_m", side, spans[k]), fmt::format("{} RPE over {} (m)", side, spans[k]), 4,
                       fmt::format("/{}/from_truth/rpe/{}/translation/rms", side, k)});
  }
}

/// An empty table: the problem, the columns that tell its ways apart, figures, and the result.
ReportTable table_with(const Columns& ways, const Columns& figures) {
  ReportTable table{{{"formulation", "problem"}, {"steps_per_map", "steps per map"}}, {}};
  for (const Columns& part : {ways, figures, {{"result", "result"}}}) {
    table.columns.insert(table.columns.end(), part.begin(), part.end());
  }
  return table;
}

RowKind kind_of(const CaseFigures& figures) {
  return figures.reaches_best ? RowKind::kGood : RowKind::kBad;
}

/// A table with one row per case.
ReportTable table_of(const Columns& columns, const ComparisonFigures& comparison, const Json& cases) {
  ReportTable table = table_with({{"state", "state"}, {"schedule", "schedule"}}, columns);
  for (std::size_t k = 0; k < cases.size(); ++k) table.add(cases[k], kind_of(comparison.cases[k]));
  return table;
}

/// True if two cases give the same maps, joined and polished.
bool are_alike(const CaseFigures& a, const CaseFigures& b) {
  const auto is_same = [](double x, double y) { return std::abs(x - y) <= kShownAlike * std::max({1.0, x, y}); };
  return a.way.poses_per_map == b.way.poses_per_map && a.failure == b.failure && a.reaches_best == b.reaches_best &&
         is_same(a.joined.chi2, b.joined.chi2) && is_same(a.polished.chi2, b.polished.chi2);
}

/// The alike ways in words: "all", "all but …", or their names.
std::string ways_in_words(const std::vector<std::size_t>& alike, const std::vector<CaseFigures>& cases) {
  std::vector<std::string> ours, others;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const ComparedCase& way = cases[k].way;
    if (way.poses_per_map != cases[alike.front()].way.poses_per_map) continue;
    const bool is_ours = std::find(alike.begin(), alike.end(), k) != alike.end();
    (is_ours ? ours : others).push_back(to_string(way.state) + " " + schedule_in_words(way));
  }
  if (others.empty()) return "all";
  return others.size() < ours.size() ? fmt::format("all but {}", fmt::join(others, ", "))
                                     : fmt::format("{}", fmt::join(ours, ", "));
}

/// A table with one row for all cases that are alike, with the figures of the one farthest from the best map.
ReportTable short_table_of(const Columns& columns, const ComparisonFigures& comparison, const Json& cases) {
  ReportTable table = table_with({{"ways", "ways"}}, columns);
  const auto distance = [&](std::size_t k) { return comparison.cases[k].polished.from_best.poses.translation.max; };
  std::vector<std::size_t> all(cases.size());
  std::iota(all.begin(), all.end(), 0U);
  for (const auto& alike : grouped(all, comparison.cases, are_alike)) {
    const std::size_t farthest = *std::ranges::max_element(alike, {}, distance);
    Json row = cases[farthest];
    row["ways"] = ways_in_words(alike, comparison.cases);
    table.add(row, kind_of(comparison.cases[farthest]));
  }
  return table;
}

bool has_truth(const ComparisonFigures& comparison) {
  return comparison.cases[comparison.best].polished.from_truth.has_value();
}

}  // namespace

std::string unconverged_in_words(const RunFigures& run) {
  const MinimiseStatus last = (run.polish ? *run.polish : run.join).status;
  return run.converged() ? "" : "did not converge: " + to_string(last);
}

std::string result_in_words(const CaseFigures& figures) {
  if (!figures.has_map()) return figures.failure;
  if (!figures.run.converged()) return unconverged_in_words(figures.run);
  const std::string where = figures.reaches_best ? "best" : "another minimum";
  return figures.run.join.status == MinimiseStatus::kConverged ? where : where + ", though the join did not converge";
}

std::vector<std::string> notes_of(const RunReport& run_report, const ComparisonFigures& comparison) {
  std::vector<std::string> notes = notes_of(run_report);
  int told = 0;  // the length of the last note
  for (const CaseFigures& figures : comparison.cases) {
    const int length = figures.way.poses_per_map;
    if (!figures.has_map() || figures.way.is_full_slam() || figures.run.local_maps > 0 || length == told) continue;
    notes.push_back(no_map_in_words({SplitRule::kPoses, static_cast<double>(length)}));
    told = length;
  }
  return notes;
}

std::vector<NamedTable> tables_of(const ComparisonFigures& comparison, const Json& cases) {
  std::vector<NamedTable> tables = {
      {"What each way takes",
       "chi2 of the join is over the local maps; before polishing and polished, of the whole log. Iterations are those of the "
       "last join and of the polish. System: the local maps' information matrices and the factor of the joint system. Memory: "
       "by how much the process grew at most.",
       table_of(kCost, comparison, cases)}};
  std::vector<Part> parts = {kPoses};
  if (comparison.cases[comparison.best].polished.from_best.features.count > 0) parts.push_back(kFeatures);
  Columns distances;
  add_distances("joined", parts, distances);
  add_spans("joined", comparison.spans, kForPeople, distances);
  add_distances("polished", parts, distances);
  tables.push_back(
      {"How far its map is from the best one",
       "Joined: before polishing. Positions as they stand, in the frame of the map. Over so many steps: the "
       "motion from every pose to the one so much later, root mean square of the differences of position. Ways of the same "
       "maps share a row.",
       short_table_of(distances, comparison, cases)});
  if (!has_truth(comparison)) return tables;
  Columns truth;
  for (const char* side : {"joined", "polished"}) add_truth(side, comparison.spans, kForPeople, truth);
  tables.push_back({"How far it is from the truth",
                    "ATE: positions after alignment. RPE: the motion over so many steps. Root mean squares.",
                    short_table_of(truth, comparison, cases)});
  return tables;
}

ReportTable whole_table(const ComparisonFigures& comparison, const Json& cases) {
  Columns columns = kCost;
  for (const char* side : {"joined", "polished"}) {
    add_distances(side, {kPoses, kTurns, kFeatures}, columns);
    add_spans(side, comparison.spans, 1, columns);
    if (has_truth(comparison)) add_truth(side, comparison.spans, 1, columns);
  }
  return table_of(columns, comparison, cases);
}

}  // namespace mapjoin::apps
