// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The programs that mapjoin_speed compares on one file, and the cost and the result of one run of each.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::bench {

/// The share by which chi2 may be above the optimum that counts as reached.
inline constexpr double kAsGood = 1e-6;

/// A log, or local maps to be joined.
struct Data {
  std::string name;
  std::filesystem::path source;  ///< File as given or simulated.
  std::filesystem::path file;    ///< File that the programs read; a store for local maps.
  bool is_maps = false;
};

/// The settings of the programs.
struct Surroundings {
  std::filesystem::path programs;  ///< Folder of the programs.
  std::filesystem::path folder;    ///< Folder for their outputs.
  double optimum = 0.0;            ///< Least chi2 seen; infinite if none.
  std::size_t most_seconds = 0;    ///< CPU limit of the others (s); 0: none.
};

enum class ProgramKind : std::uint8_t {
  kOurs,   ///< Run to its end.
  kOther,  ///< Stopped after Surroundings::most_seconds.
  kLimit,  ///< Reports its CPU time and memory itself, since its start-up does not count.
};

struct Program {
  std::string name;
  ProgramKind kind = ProgramKind::kOurs;
  std::vector<std::string> (*words)(const Data&, const Surroundings&);
};

/// The programs for a log or local maps; the first, `run` or `join`, is the one to compare with.
std::vector<Program> programs_for(const Data& data);

/// One run of a program.
struct Trial {
  double cpu_seconds = 0.0;
  double wall_seconds = 0.0;
  double memory_mb = 0.0;      ///< The largest resident memory (10⁶ bytes).
  std::optional<double> chi2;  ///< chi2 as all of them evaluate it; nullopt on failure.
  std::string failure;         ///< Reason why there is no chi2.
  nlohmann::json said;
};

/// Makes the map at which the limit is measured, by `run` or `join`.
void make_map(const Data& data, const Surroundings& surroundings);

Trial try_program(const Program& program, const Data& data, const Surroundings& surroundings);

/// The standard output of a program; nullopt if it fails.
std::optional<std::string> said_by(const std::vector<std::string>& words);

}  // namespace mapjoin::bench
