// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `mapjoin compare` found: tables for people, from the report and for CSV, and a page with pictures.

#include <algorithm>
#include <apps/report/run_report.hpp>
#include <apps/report/table.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// The optimum with the other weights than those compared (paper's Fig. 1).
template <int Dim>
struct OtherWeights {
  Covariance covariance = Covariance::kIdentity;
  std::string failure;  ///< Why there is no map, or nothing.
  double chi2 = 0.0;
  MapDifference from_best;  ///< From the best map of the comparison.
  GlobalMap<Dim> map;
};

/// "best", "another minimum", either although the join did not converge, "did not converge: …", or why there is no map.
std::string result_in_words(const CaseFigures& figures);

/// Cases in groups of those that are alike, by the first of each; in their order.
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

struct NamedTable {
  std::string name;
  std::string note;  ///< What its columns mean.
  ReportTable table;
};

/// For people: what each case takes, then how far its map is from the best one and from the truth, where that is known.
/// `cases` are those of the report, here and below.
std::vector<NamedTable> tables_of(const ComparisonFigures& comparison, const Json& cases);

/// All figures in one table.
ReportTable whole_table(const ComparisonFigures& comparison, const Json& cases);

template <int Dim>
std::string compare_page(const RunReport& run_report, const Comparison<Dim>& comparison, const OtherWeights<Dim>& other,
                         const std::vector<NamedTable>& tables, const std::vector<Session>& sessions);

}  // namespace mapjoin::apps
