// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The figures of a comparison as tables.

#include <apps/report/table.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

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

}  // namespace mapjoin::apps
