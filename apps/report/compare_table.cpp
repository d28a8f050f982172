// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/report/compare_report.hpp>
#include <cmath>
#include <functional>
#include <utility>

namespace mapjoin::apps {
namespace {

constexpr int kChi2Digits = 10;
constexpr int kTimeDigits = 3;
constexpr int kErrorDigits = 2;
constexpr double kShownAlike = 1e-4;     // for people, as a share of it
constexpr std::size_t kForPeople = 3;  // of 1, 2, 5, 10, …: the powers of ten

/// A column, and what stands in it of a case that gives a map.
struct Figure {
  Column column;
  std::function<Cell(const CaseFigures&)> of;
};
using Figures = std::vector<Figure>;

/// The joined estimate or the polished one.
struct Side {
  EstimateFigures CaseFigures::*estimate;
  std::string name;
};
const Side kJoined{&CaseFigures::joined, "joined"};
const Side kPolished{&CaseFigures::polished, "polished"};

Cell bytes_in_mb(std::int64_t bytes) {
  return 1e-6 * static_cast<double>(bytes);
}

void add_distances(const Side& side, const std::vector<std::string>& parts, Figures& figures) {
  const auto add = [&](const std::string& what, const std::string& unit, auto part) {
    if (std::find(parts.begin(), parts.end(), what) == parts.end()) return;
    for (const auto& [word, value] : {std::pair{"max", &ErrorSummary::max}, {"rms", &ErrorSummary::rms}}) {
      figures.push_back({{fmt::format("{}_{}_{}_{}", side.name, what, word, unit),
                          fmt::format("{} {} {} ({})", side.name, what, word, unit), kErrorDigits},
                         [side, part, value = value](const CaseFigures& c) -> Cell {
                           const ErrorSummary errors = part((c.*side.estimate).from_best);
                           return errors.count > 0 ? Cell(errors.*value) : Cell();
                         }});
    }
  };
  add("poses", "m", [](const MapDifference& d) { return d.poses.translation; });
  add("turns", "rad", [](const MapDifference& d) { return d.poses.rotation; });
  add("features", "m", [](const MapDifference& d) { return d.features; });
}

/// Of every span, or, for people, of every third: powers of ten.
void add_spans(const Side& side, const std::vector<std::size_t>& spans, std::size_t every, Figures& figures) {
  for (std::size_t k = 0; k < spans.size(); k += every) {
    figures.push_back({{fmt::format("{}_relative_{}_m", side.name, spans[k]),
                        fmt::format("{} over {} (m)", side.name, spans[k]), kErrorDigits},
                       [side, k](const CaseFigures& c) { return (c.*side.estimate).best_spans[k].translation.rms; }});
  }
}

void add_truth(const Side& side, const std::vector<std::size_t>& spans, std::size_t every, Figures& figures) {
  figures.push_back({{side.name + "_ate_m", side.name + " ATE (m)", kErrorDigits + 2},
                     [side](const CaseFigures& c) { return (c.*side.estimate).from_truth->absolute.translation.rms; }});
  for (std::size_t k = 0; k < spans.size(); k += every) {
    figures.push_back({{fmt::format("{}_rpe_{}_m", side.name, spans[k]), fmt::format("{} RPE over {} (m)", side.name, spans[k]),
                        kErrorDigits + 2},
                       [side, k](const CaseFigures& c) { return (c.*side.estimate).from_truth->spans[k].translation.rms; }});
  }
}

Figures cost_figures() {
  return {
      {{"join_chi2", "chi2 of the join", kChi2Digits}, [](const CaseFigures& c) { return c.run.join.chi2; }},
      {{"joined_chi2", "chi2 before polishing", kChi2Digits}, [](const CaseFigures& c) { return c.joined.chi2; }},
      {{"polished_chi2", "chi2 polished", kChi2Digits}, [](const CaseFigures& c) { return c.polished.chi2; }},
      {{"join_iterations", "join iter."}, [](const CaseFigures& c) { return std::int64_t{c.join_iterations()}; }},
      {{"polish_iterations", "polish iter."}, [](const CaseFigures& c) { return std::int64_t{c.polish_iterations()}; }},
      {{"seconds", "time (s)", kTimeDigits}, [](const CaseFigures& c) { return c.effort.seconds; }},
      {{"cpu_seconds", "CPU (s)", kTimeDigits}, [](const CaseFigures& c) { return c.effort.cpu_seconds; }},
      {{"system_mb", "system (MB)", kTimeDigits}, [](const CaseFigures& c) { return bytes_in_mb(c.run.joint_bytes); }},
      {{"memory_mb", "memory (MB)", kTimeDigits},
       [](const CaseFigures& c) { return c.effort.memory ? bytes_in_mb(*c.effort.memory) : Cell(); }},
  };
}

Row row_of(const Figures& figures, const CaseFigures& c, std::vector<Cell> begin) {
  Row row{std::move(begin), c.reaches_best ? RowKind::kGood : RowKind::kBad};
  for (const Figure& figure : figures) row.cells.push_back(c.has_map() ? figure.of(c) : Cell());
  row.cells.emplace_back(result_in_words(c));
  return row;
}

Table with_columns(std::vector<Column> begin, const Figures& figures) {
  Table table{{{"formulation", "problem"}, {"steps_per_map", "steps per map"}}, {}};
  table.columns.insert(table.columns.end(), begin.begin(), begin.end());
  for (const Figure& figure : figures) table.columns.push_back(figure.column);
  table.columns.push_back({"result", "result"});
  return table;
}

std::vector<Cell> problem_of(const CaseFigures& c) {
  return {problem_in_words(c.way.formulation()), std::int64_t{c.way.poses_per_map}};
}

/// One row per case.
Table table_of(const Figures& figures, const ComparisonFigures& comparison) {
  Table table = with_columns({{"state", "state"}, {"schedule", "schedule"}}, figures);
  for (const CaseFigures& c : comparison.cases) {
    std::vector<Cell> begin = problem_of(c);
    begin.insert(begin.end(), {to_string(c.way.state), schedule_in_words(c.way)});
    table.rows.push_back(row_of(figures, c, std::move(begin)));
  }
  return table;
}

/// Cases of the same maps, joined and polished.
using Alike = std::vector<const CaseFigures*>;

bool are_alike(const CaseFigures& a, const CaseFigures& b) {
  const auto is_same = [](double x, double y) { return std::abs(x - y) <= kShownAlike * std::max({1.0, x, y}); };
  return a.way.poses_per_map == b.way.poses_per_map && a.failure == b.failure && a.reaches_best == b.reaches_best &&
         is_same(a.joined.chi2, b.joined.chi2) && is_same(a.polished.chi2, b.polished.chi2);
}

std::vector<Alike> alike_in(const ComparisonFigures& comparison) {
  std::vector<Alike> groups;
  for (const CaseFigures& c : comparison.cases) {
    const auto group =
        std::find_if(groups.begin(), groups.end(), [&](const Alike& alike) { return are_alike(*alike.front(), c); });
    (group == groups.end() ? groups.emplace_back() : *group).push_back(&c);
  }
  return groups;
}

/// "all", "all but …", or the names of those that are alike.
std::string ways_in_words(const Alike& alike, const ComparisonFigures& comparison) {
  std::vector<std::string> ours;
  std::vector<std::string> others;
  for (const CaseFigures& c : comparison.cases) {
    if (c.way.poses_per_map != alike.front()->way.poses_per_map) continue;
    const bool is_ours = std::find(alike.begin(), alike.end(), &c) != alike.end();
    (is_ours ? ours : others).push_back(to_string(c.way.state) + " " + schedule_in_words(c.way));
  }
  if (others.empty()) return "all";
  if (others.size() < ours.size()) return fmt::format("all but {}", fmt::join(others, ", "));
  return fmt::format("{}", fmt::join(ours, ", "));
}

/// One row for all cases that are alike, with the figures of the one farthest from the best map.
Table short_table_of(const Figures& figures, const ComparisonFigures& comparison) {
  Table table = with_columns({{"ways", "ways"}}, figures);
  const auto is_nearer = [](const CaseFigures* a, const CaseFigures* b) {
    return a->polished.from_best.poses.translation.max < b->polished.from_best.poses.translation.max;
  };
  for (const Alike& alike : alike_in(comparison)) {
    const CaseFigures& farthest = **std::max_element(alike.begin(), alike.end(), is_nearer);
    std::vector<Cell> begin = problem_of(farthest);
    begin.emplace_back(ways_in_words(alike, comparison));
    table.rows.push_back(row_of(figures, farthest, std::move(begin)));
  }
  return table;
}

bool has_truth(const ComparisonFigures& comparison) {
  return comparison.cases[comparison.best].polished.from_truth.has_value();
}

}  // namespace

std::string result_in_words(const CaseFigures& figures) {
  if (!figures.has_map()) return figures.failure;
  const RunFigures& run = figures.run;
  const MinimiseStatus last = (run.polish ? *run.polish : run.join).status;
  if (!run.converged()) return "did not converge: " + to_string(last);
  const std::string where = figures.reaches_best ? "best" : "another minimum";
  return run.join.status == MinimiseStatus::kConverged ? where : where + ", though the join did not converge";
}

std::vector<NamedTable> tables_of(const ComparisonFigures& comparison) {
  std::vector<NamedTable> tables = {
      {"What each way takes",
       "chi2 of the join is over the local maps; before polishing and polished, of the whole log. Iterations are those of the "
       "last join and of the polish. System: the local maps' information matrices and the factor of the joint system. Memory: "
       "by how much the process grew at most.",
       table_of(cost_figures(), comparison)}};
  std::vector<std::string> parts = {"poses"};
  if (comparison.cases[comparison.best].polished.from_best.features.count > 0) parts.emplace_back("features");
  Figures distances;
  add_distances(kJoined, parts, distances);
  add_spans(kJoined, comparison.spans, kForPeople, distances);
  add_distances(kPolished, parts, distances);
  tables.push_back(
      {"How far its map is from the best one",
       "Joined: before polishing. Poses and features as they stand, in the frame of the first pose. Over so many steps: the "
       "motion from every pose to the one so much later, root mean square of the differences of position. Ways of the same "
       "maps share a row.",
       short_table_of(distances, comparison)});
  if (!has_truth(comparison)) return tables;
  Figures truth;
  for (const Side* side : {&kJoined, &kPolished}) add_truth(*side, comparison.spans, kForPeople, truth);
  tables.push_back({"How far it is from the truth",
                    "ATE: positions after alignment. RPE: the motion over so many steps. Root mean squares.",
                    short_table_of(truth, comparison)});
  return tables;
}

Table whole_table(const ComparisonFigures& comparison) {
  Figures figures = cost_figures();
  for (const Side* side : {&kJoined, &kPolished}) {
    add_distances(*side, {"poses", "turns", "features"}, figures);
    add_spans(*side, comparison.spans, 1, figures);
    if (has_truth(comparison)) add_truth(*side, comparison.spans, 1, figures);
  }
  return table_of(figures, comparison);
}

}  // namespace mapjoin::apps
