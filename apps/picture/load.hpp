// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Maps from any input that can be plotted, with the files that mapjoin left beside them, and with their growth while local maps
// are joined. All of it may fail() (see exit_code.hpp).

#include <apps/exit_code.hpp>
#include <apps/picture/plotted_map.hpp>
#include <filesystem>
#include <functional>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin::apps {

struct LoadOptions {
  ReadOptions read;
  RunOptions run;                                          ///< Options for joining local maps first.
  bool has_stops = false;                                  ///< True to record the join, map after map.
  std::function<void(std::size_t, std::size_t)> progress;  ///< Progress of recording, as in ScheduleOptions.
};

struct LoadedMap {
  AnyPlottedMap plotted;
  ExitCode exit_code = ExitCode::kDone;   ///< Exit code of the join, as of `mapjoin join`.
  std::vector<std::string> remarks = {};  ///< Sentences on what is wrong, to follow the name of the input.
};

/// Loads a log by its values or its odometry; a map that mapjoin wrote, or the folder of a run, with the files beside it; or
/// local maps, which are joined. kInterrupted on `stop`.
LoadedMap load(const std::filesystem::path& path, const LoadOptions& options, const std::stop_token& stop);

/// The stops of joining a submap graph map after map, as Schedule::kSequential does, each in the frame of `map`, the final one:
/// after every map or, if there are many, after so many that a page can hold all stops. Maps not yet tied to the first pose are
/// left out. The last stop holds all maps, before the last solve.
template <int Dim>
std::vector<JoinStop<Dim>> join_stops(const SubmapGraph<Dim>& graph, const GlobalMap<Dim>& map,
                                      const std::function<void(std::size_t, std::size_t)>& progress,
                                      const std::stop_token& stop);

}  // namespace mapjoin::apps
