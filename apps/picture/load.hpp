// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whatever can be plotted, as maps.

#include <apps/exit_code.hpp>
#include <apps/picture/plotted_map.hpp>
#include <filesystem>
#include <functional>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/error.hpp>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin::apps {

struct LoadOptions {
  ReadOptions read;
  RunOptions run;                                          ///< Of local maps, which are joined first.
  bool has_stops = false;                                  ///< Watch that, map after map.
  std::function<void(std::size_t, std::size_t)> progress;  ///< Of watching, as in ScheduleOptions.
};

struct LoadedMap {
  AnyPlottedMap plotted;
  ExitCode exit_code = ExitCode::kDone;   ///< Of joining, as `mapjoin join` has it,
  std::vector<std::string> remarks = {};  ///< and what is wrong with it, to follow the name of the input.
};

/// A log by its values or its odometry; a map that mapjoin wrote, or the folder of a run, with what is beside it; local maps
/// joined. kInterrupted on `stop`.
Expected<LoadedMap> load(const std::filesystem::path& path, const LoadOptions& options, const std::stop_token& stop);

}  // namespace mapjoin::apps
