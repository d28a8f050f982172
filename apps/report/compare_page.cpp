// SPDX-License-Identifier: BSD-3-Clause
// A self-contained page for a browser, in HTML that is well-formed XML, too: text, tables and pictures, and nothing to be
// fetched.
#include <fmt/format.h>

#include <algorithm>
#include <apps/picture/markup.hpp>
#include <apps/picture/picture.hpp>
#include <apps/report/compare_report.hpp>
#include <apps/report/report.hpp>
#include <apps/report/verdict.hpp>
#include <filesystem>
#include <mapjoin/join/tolerances.hpp>
#include <string_view>
#include <utility>
#include <vector>

namespace mapjoin::apps {

namespace embedded {
extern const std::string_view compare_style;  // Embedded from compare.css by cmake/embed.cmake.
}

namespace {

constexpr double kPixels = 560.0;  // longer side of the pictures: small enough for the words in them to be read on a phone

/// An element with escaped text.
std::string element(const std::string& name, const std::string& text, const std::string& attributes = "") {
  return fmt::format("<{0}{1}>{2}</{0}>", name, attributes, escaped(text));
}

std::string paragraph(const std::string& text) {
  return element("p", text) + "\n";
}
/// A picture with its caption, scaled to the width of the page.
std::string figure(const std::vector<Layer>& layers, const std::string& caption) {
  return "<figure>\n" + picture(layers, kPixels) + element("figcaption", caption) + "\n</figure>\n";
}

/// The table in HTML: numbers to the right, good and bad rows told apart.
std::string table_of(const ReportTable& table) {
  std::vector<std::string> attributes;
  std::string html = "<div class=\"wide\"><table>\n<thead><tr>";
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    attributes.emplace_back(is_numeric(table, c) ? " class=\"number\"" : "");
    html += element("th", table.columns[c].heading, " scope=\"col\"" + attributes[c]);
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const Row& row : table.rows) {
    html += row.kind == RowKind::kGood ? "<tr class=\"good\">" : "<tr class=\"bad\">";
    for (std::size_t c = 0; c < row.cells.size(); ++c) {
      html += element("td", shown(row.cells[c], table.columns[c]), attributes[c]);
    }
    html += "</tr>\n";
  }
  return html + "</tbody>\n</table></div>\n";
}

std::string introduction(const ComparisonFigures& comparison) {
  const auto reached = std::count_if(comparison.cases.begin(), comparison.cases.end(),
                                     [](const CaseFigures& figures) { return figures.reaches_best; });
  const CaseFigures& best = comparison.cases[comparison.best];
  return fmt::format(
      "One log, made into a map in {} ways. Full SLAM adjusts all poses and features in one least-squares problem. Joining "
      "solves short local maps first, joins them, and polishes the result on the whole log. Steps are taken in the absolute "
      "coordinates of the map, or relative to where each pose and feature hangs. In the end all minimise the same chi2, so "
      "that the least one is the best map: chi2 {:.10g} over {} degrees of freedom. {} of the {} ways reach it.",
      comparison.cases.size(), best.polished.chi2, best.run.dof, reached, comparison.cases.size());
}

/// The log, what was rejected of it, how its chi2 is weighed, and notes, as a list of terms.
std::string description(const RunReport& run_report, const ComparisonFigures& comparison) {
  std::vector<std::pair<std::string, std::string>> terms = {
      {"Log", counts_in_words(run_report)},
      {"chi2", conventions_in_words(run_report.conventions, run_report.dimension)},
      {"Method", to_string(run_report.options.solver.method)}};
  if (run_report.robust) {
    terms.emplace_back("Rejected", rejected_in_words(run_report) + ": no map is made of these, nor does any chi2 count them");
  }
  for (std::string& note : notes_of(run_report, comparison)) terms.emplace_back("Note", std::move(note));
  std::string list = "<dl>\n";
  for (const auto& [name, text] : terms) list += element("dt", name) + element("dd", text) + "\n";
  return list + "</dl>\n";
}

/// Groups of cases that end in the same map, by its chi2; the best first.
std::vector<std::vector<std::size_t>> solutions_of(const std::vector<CaseFigures>& cases) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    if (cases[k].has_map()) order.push_back(k);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return cases[k].polished.chi2; });
  return grouped(order, cases,
                 [](const CaseFigures& a, const CaseFigures& b) { return is_same_chi2(a.polished.chi2, b.polished.chi2); });
}

/// The best map, and beside it the trajectories of as many others as there are colours for.
template <int Dim>
std::string picture_of_solutions(const Comparison<Dim>& comparison, const std::vector<Session>& sessions) {
  const auto solutions = solutions_of(comparison.cases);
  const std::size_t drawn = std::min(solutions.size(), kDistinctColours.size());
  std::vector<Layer> layers;
  for (std::size_t s = drawn; s-- > 0;) {
    const CaseFigures& first = comparison.cases[solutions[s].front()];
    const GlobalMap<Dim>& map = comparison.maps[solutions[s].front()].polished;
    const std::size_t ways = solutions[s].size();
    const std::string what = ways > 1 ? fmt::format("{} ways", ways) : to_string(first.way);
    Layer layer{fmt::format("chi2 {:.7g}: {}", first.polished.chi2, what),
                {kDistinctColours[s]},
                trajectory_lines(map.poses, sessions),
                s == 0 ? from_above(map.features) : std::vector<Point<2>>(),
                {},
                s == 0 ? 1.4 : 1.0};
    layer.is_framed = s == 0;
    layers.push_back(std::move(layer));
  }
  const bool has_features = !comparison.maps[comparison.best].polished.features.empty();
  std::string caption = fmt::format("The best map: trajectory{}.", has_features ? " and features" : "");
  if (drawn > 1) caption += " Beside it the trajectories of the other maps, as far as they lie within its frame.";
  if (solutions.size() > drawn) caption += fmt::format(" {} more are not drawn.", solutions.size() - drawn);
  return figure(layers, caption);
}

template <int Dim>
std::string about_weights(const Comparison<Dim>& comparison, Covariance compared, const OtherWeights<Dim>& other,
                          const std::vector<Session>& sessions) {
  const auto named = [](Covariance covariance) { return to_string(covariance) + " covariance"; };
  if (!other.failure.empty()) {
    return paragraph(fmt::format("With the {} there is no map: {}", named(other.covariance), other.failure));
  }
  const MapDifference& apart = other.from_best;
  const auto size_of = [](const ErrorSummary& errors) {
    return fmt::format("{:.2g} m (root mean square; {:.2g} m at most)", errors.rms, errors.max);
  };
  const bool has_features = apart.features.count > 0;
  const std::string features = has_features ? ", the features by " + size_of(apart.features) : "";
  const auto layer_of = [&](const GlobalMap<Dim>& map, Covariance covariance, const char* colour, Mark mark) {
    return Layer{named(covariance), {colour}, trajectory_lines(map.poses, sessions), from_above(map.features), {}, 1.2, mark};
  };
  const std::string unconverged =
      other.run.converged() ? "" : fmt::format(" This map is no optimum: its solve {}.", unconverged_in_words(other.run));
  return paragraph(fmt::format("The same log with the {} instead of the {}: the poses move by {}{}.{}", named(other.covariance),
                               named(compared), size_of(apart.poses.translation), features, unconverged)) +
         figure({layer_of(other.map, other.covariance, kDistinctColours[1], Mark::kRing),
                 layer_of(comparison.maps[comparison.best].polished, compared, kDistinctColours[0], Mark::kDot)},
                has_features
                    ? fmt::format("Trajectories, and features: rings with the {}, dots with the {}.", named(other.covariance),
                                  named(compared))
                    : fmt::format("Trajectories with the {} and with the {}.", named(other.covariance), named(compared)));
}

}  // namespace

template <int Dim>
std::string compare_page(const RunReport& run_report, const Comparison<Dim>& comparison, const OtherWeights<Dim>& other,
                         const std::vector<NamedTable>& tables, const std::vector<Session>& sessions) {
  const std::string title = "Joining beside full SLAM: " + std::filesystem::path(run_report.input).filename().string();
  std::string body = element("h1", title) + "\n" + paragraph(introduction(comparison)) + description(run_report, comparison);
  for (const auto& [name, note, table] : tables) {
    body += element("h2", name) + "\n" + table_of(table) + element("p", note, " class=\"note\"") + "\n";
  }
  body += element("h2", "The maps") + "\n" + picture_of_solutions(comparison, sessions) +
          element("h2", "Original and identity covariance") + "\n" +
          about_weights(comparison, run_report.conventions.covariance, other, sessions);
  return html_page(title, embedded::compare_style, body);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                        \
  template std::string compare_page(const RunReport&, const Comparison<Dim>&, const OtherWeights<Dim>&, \
                                    const std::vector<NamedTable>&, const std::vector<Session>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
