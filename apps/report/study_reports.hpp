// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the studies found: tables for people, reports by docs/report.md and CSV for programs, and a page with pictures.

#include <apps/report/run_report.hpp>
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

}  // namespace mapjoin::apps
