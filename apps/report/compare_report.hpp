// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A comparison as JSON, by docs/report.md.

#include <apps/report/run_report.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <mapjoin/model/conventions.hpp>
#include <optional>
#include <string>

namespace mapjoin::apps {

/// The optimum with the other weights than those compared (paper's Fig. 1).
struct OtherWeights {
  Covariance covariance = Covariance::kIdentity;
  std::string failure;  ///< Why there is no map, or nothing.
  double chi2 = 0.0;
  MapDifference from_best;  ///< From the best map of the comparison.
};

std::string compare_report(const Account& account, const ComparisonFigures& comparison, const OtherWeights& other);

}  // namespace mapjoin::apps
