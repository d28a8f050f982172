// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What mapjoin_speed found: medians and ratios, as a table and as JSON.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "speed_programs.hpp"

namespace mapjoin::bench {

/// The runs of one program on one file, round by round; one that fails is not run again.
struct Runs {
  Program program;
  std::vector<Trial> trials;
};

struct Result {
  Data data;
  std::string sha256;
  double optimum = 0.0;    ///< The least chi2 seen.
  std::vector<Runs> runs;  ///< The first, mapjoin on one thread, is compared with the others.
};

using Figure = double Trial::*;
double median_of(const Runs& runs, Figure figure);
/// 0 where no program says it.
std::int64_t pose_count(const Result& result);

/// A line per file and program, in Markdown.
std::string table_of(const std::vector<Result>& results);
nlohmann::json json_of(const std::vector<Result>& results);

}  // namespace mapjoin::bench
