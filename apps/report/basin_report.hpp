// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `mapjoin basin` found: as a table for people, as CSV and JSON for programs.

#include <apps/report/run_report.hpp>
#include <mapjoin/join/study/basin.hpp>
#include <string>

namespace mapjoin::apps {

/// The input and the best chi2 known; then a row per covariance, formulation, split and method and a column per start, as in
/// the paper's Table I.
std::string basin_table(const Basin& basin, const RunReport& run_report);

/// A row per solve.
std::string basin_csv(const Basin& basin);

/// The input and its convention, the best chi2 known, and all cells with their solves.
std::string basin_json(const Basin& basin, const RunReport& run_report);

}  // namespace mapjoin::apps
