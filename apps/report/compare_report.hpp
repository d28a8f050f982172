// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The parts of compare_output(): tables, whose rows are the cases of the report, and the page.

#include <apps/report/study_reports.hpp>
#include <apps/report/table.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// "best", "another minimum", either although the join did not converge, "did not converge: …", or why there is no map.
std::string result_in_words(const CaseFigures& figures);

struct NamedTable {
  std::string name;
  std::string note;  ///< What its columns mean.
  Table table;
};

/// For people: what each case takes, then how far its map is from the best one and from the truth, where that is known.
/// `cases` are those of the report, here and below.
std::vector<NamedTable> tables_of(const ComparisonFigures& comparison, const Json& cases);

/// All figures in one table.
Table whole_table(const ComparisonFigures& comparison, const Json& cases);

template <int Dim>
std::string compare_page(const RunReport& run_report, const Comparison<Dim>& comparison, const OtherWeights<Dim>& other,
                         const std::vector<NamedTable>& tables, const std::vector<Session>& sessions);

}  // namespace mapjoin::apps
