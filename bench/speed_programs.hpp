// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The programs that mapjoin_speed compares on one file, and what one run of each takes and reaches.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::bench {

/// The optimum is reached where chi2 is above it by no more than this share.
inline constexpr double kAsGood = 1e-6;

/// A log, or local maps to be joined.
struct Data {
  std::string name;
  std::filesystem::path source;  ///< As it was given or simulated.
  std::filesystem::path file;    ///< What the programs read: of local maps, a store.
  bool is_maps = false;
};

/// What the programs are told.
struct Surroundings {
  std::filesystem::path programs;  ///< The folder that they are in.
  std::filesystem::path folder;    ///< For what they write.
  double optimum = 0.0;            ///< The least chi2 seen; infinite where there is none.
  std::size_t most_seconds = 0;    ///< CPU that the others have.
};

enum class ProgramKind : std::uint8_t {
  kOurs,   ///< As long as it takes.
  kOther,  ///< Stopped after Surroundings::most_seconds.
  kLimit,  ///< Says itself what CPU and memory it took, for its start is not part of it.
};

struct Program {
  std::string name;
  ProgramKind kind = ProgramKind::kOurs;
  std::vector<std::string> (*words)(const Data&, const Surroundings&);
};

/// The one to compare with first: `run` of a log, `join` of local maps.
std::vector<Program> programs_for(const Data& data);

/// One run of a program.
struct Trial {
  double cpu_seconds = 0.0;
  double wall_seconds = 0.0;
  double memory_mb = 0.0;      ///< The largest resident memory (10⁶ bytes).
  std::optional<double> chi2;  ///< As all of them evaluate it; nothing where there is none.
  std::string failure;         ///< Why there is none.
  nlohmann::json said;
};

/// Has the map made at which the limit is taken, `run` or `join` writing it.
void make_map(const Data& data, const Surroundings& surroundings);

Trial try_program(const Program& program, const Data& data, const Surroundings& surroundings);

/// What a program says on standard output, without a line's end; nothing where it fails.
std::optional<std::string> said_by(const std::vector<std::string>& words);

}  // namespace mapjoin::bench
