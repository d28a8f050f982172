// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The results of `mapjoin compare`: tables, made from the report, for people and for CSV, and a page with pictures.

#include <algorithm>
#include <apps/report/run_report.hpp>
#include <apps/report/table.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// The optimum with the weights that are not compared (paper's Fig. 1).
template <int Dim>
struct OtherWeights {
  Covariance covariance = Covariance::kIdentity;
  std::string failure;  ///< Reason why there is no map; empty if there is one.
  RunFigures run;
  MapDifference from_best;  ///< Difference from the best map of the comparison.
  GlobalMap<Dim> map;
};

/// How a run that did not converge ended: "did not converge: " and a status; empty if it converged.
std::string unconverged_in_words(const RunFigures& run);

/// The result in words: "best" or "another minimum", with a remark if only the join did not converge; "did not converge: …"; or
/// the reason why there is no map.
std::string result_in_words(const CaseFigures& figures);

/// Groups of alike cases, each case compared with the first of a group; in their order.
template <typename AreAlike>
std::vector<std::vector<std::size_t>> grouped(const std::vector<std::size_t>& order, const std::vector<CaseFigures>& cases,
                                              AreAlike&& are_alike) {
  std::vector<std::vector<std::size_t>> groups;
  for (const std::size_t k : order) {
    const auto fits = [&](const auto& group) { return are_alike(cases[group.front()], cases[k]); };
    const auto group = std::ranges::find_if(groups, fits);
    (group == groups.end() ? groups.emplace_back() : *group).push_back(k);
  }
  return groups;
}

/// Notes on the data, and on lengths that cut the log into no local map.
std::vector<std::string> notes_of(const RunReport& run_report, const ComparisonFigures& comparison);

struct NamedTable {
  std::string name;
  std::string note;  ///< Meaning of its columns.
  ReportTable table;
};

/// Tables for people: the cost of each case, then the distance of its map from the best one and, if known, from the truth.
/// `cases` are those of the report.
std::vector<NamedTable> tables_of(const ComparisonFigures& comparison, const Json& cases);

/// All figures in one table; `cases` are those of the report.
ReportTable whole_table(const ComparisonFigures& comparison, const Json& cases);

template <int Dim>
std::string compare_page(const RunReport& run_report, const Comparison<Dim>& comparison, const OtherWeights<Dim>& other,
                         const std::vector<NamedTable>& tables, const std::vector<Session>& sessions);

}  // namespace mapjoin::apps
