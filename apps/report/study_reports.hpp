// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the studies found: tables for people, reports by docs/report.md and CSV for programs, and a page with pictures.

#include <apps/report/run_report.hpp>
#include <apps/report/table.hpp>
#include <mapjoin/join/study/basin.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <mapjoin/join/study/convexity.hpp>
#include <mapjoin/model/conventions.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::apps {

struct StudyOutput {
  std::string text;
  std::string json;
  std::vector<std::pair<std::string, std::string>> files;  ///< Of the folder: name and content.
};

StudyOutput basin_output(const Basin& basin, const RunReport& run_report);

StudyOutput convexity_output(const Convexity& found, const ConvexityOptions& options, const RunReport& run_report);

/// The optimum with the other weights than those compared (paper's Fig. 1).
template <int Dim>
struct OtherWeights {
  Covariance covariance = Covariance::kIdentity;
  std::string failure;  ///< Why there is no map, or nothing.
  double chi2 = 0.0;
  MapDifference from_best;  ///< From the best map of the comparison.
  GlobalMap<Dim> map;
};

/// The page is made only where there is a folder for it.
template <int Dim>
StudyOutput compare_output(const Comparison<Dim>& comparison, const OtherWeights<Dim>& other, const Log<Dim>& log,
                           const RunReport& run_report);

// The parts of compare_output().

/// "best", "another minimum", either although the join did not converge, "did not converge: …", or why there is no map.
std::string result_in_words(const CaseFigures& figures);

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
