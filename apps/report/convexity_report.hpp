// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `mapjoin convexity` found: as a table for people, as CSV and JSON for programs.

#include <apps/report/run_report.hpp>
#include <mapjoin/join/study/convexity.hpp>
#include <string>

namespace mapjoin::apps {

/// The input, how the pairs of states were drawn, and a row per formulation.
std::string convexity_table(const Convexity& found, const ConvexityOptions& options, const RunReport& run_report);

/// F at every λ: formulation, pair, lambda, F.
std::string convexity_csv(const Convexity& found);

std::string convexity_json(const Convexity& found, const ConvexityOptions& options, const RunReport& run_report);

}  // namespace mapjoin::apps
