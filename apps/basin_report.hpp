// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `mapjoin basin` found: as a table for people, as CSV and JSON for programs, and as a picture.

#include <apps/account.hpp>
#include <mapjoin/join/study/basin.hpp>
#include <string>

namespace mapjoin::apps {

/// The input and the best chi2 known; then a row per covariance, formulation, split and method and a column per start, as in
/// the paper's Table I.
std::string basin_table(const Basin& basin, const Account& account);

/// A row per solve.
std::string basin_csv(const Basin& basin);

/// The input and its convention, the best chi2 known, and all cells with their solves.
std::string basin_json(const Basin& basin, const Account& account);

/// The rate at which each cell reaches the optimum, as SVG.
std::string basin_picture(const Basin& basin);

/// The local maps of a cell, as --poses-per-map and its like name them: "20", "auto", "10 m", "15 features"; empty for full
/// SLAM and for maps that were cut before.
std::string split_in_words(const BasinCell& cell);

}  // namespace mapjoin::apps
