// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A comparison as JSON, by docs/report.md, as tables, and as a page with pictures of the maps.

#include <apps/report/run_report.hpp>
#include <apps/report/table.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <mapjoin/model/conventions.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// The optimum with the other weights than those compared (paper's Fig. 1).
struct OtherWeights {
  Covariance covariance = Covariance::kIdentity;
  std::string failure;  ///< Why there is no map, or nothing.
  double chi2 = 0.0;
  MapDifference from_best;  ///< From the best map of the comparison.
};

std::string compare_report(const RunReport& run_report, const ComparisonFigures& comparison, const OtherWeights& other);

/// "best", "another minimum", either although the join did not converge, "did not converge: …", or why there is no map.
std::string result_in_words(const CaseFigures& figures);

/// What people read: what each case takes, then how far its map is from the best one and from the truth, where that is known.
struct NamedTable {
  std::string name;
  std::string note;  ///< What its columns mean.
  Table table;
};
std::vector<NamedTable> tables_of(const ComparisonFigures& comparison);

/// All figures in one table.
Table whole_table(const ComparisonFigures& comparison);

/// `other_map` is the optimum with the other weights; without poses where there is none.
template <int Dim>
std::string compare_page(const RunReport& run_report, const Comparison<Dim>& comparison, const OtherWeights& other,
                         const GlobalMap<Dim>& other_map, const std::vector<Session>& sessions);

}  // namespace mapjoin::apps
