// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The results of mapjoin_speed: medians and ratios, as a table and as JSON.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "speed_programs.hpp"

namespace mapjoin::bench {

/// The runs of one program on one file, round by round; a program that fails is not run again.
struct Runs {
  Program program;
  std::vector<Trial> trials;
};

struct Result {
  Data data;
  std::string sha256;
  double optimum = 0.0;    ///< The least chi2 seen.
  std::vector<Runs> runs;  ///< Runs of all programs; the first, mapjoin on one thread, is compared with the others.
};

using Figure = double Trial::*;
double median_of(const Runs& runs, Figure figure);
/// The number of poses; 0 if no program reports it.
std::int64_t pose_count(const Result& result);

/// A table in Markdown, with a line per file and program.
std::string table_of(const std::vector<Result>& results);
nlohmann::json json_of(const std::vector<Result>& results);

}  // namespace mapjoin::bench
