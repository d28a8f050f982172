// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whatever can be plotted, as maps, with what mapjoin left beside them, and how they grew while local maps were joined. All of
// it may fail() (see exit_code.hpp).

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
LoadedMap load(const std::filesystem::path& path, const LoadOptions& options, const std::stop_token& stop);

/// The submap graph joined map after map, as Schedule::kSequential does, each stop in the frame of `map`, the whole one: after
/// every map, or of many after so many that a page can hold all stops. What is not yet tied to the first pose is left out. The
/// last stop holds all maps, not yet solved for the last time.
template <int Dim>
std::vector<JoinStop<Dim>> join_stops(const SubmapGraph<Dim>& graph, const GlobalMap<Dim>& map,
                                      const std::function<void(std::size_t, std::size_t)>& progress,
                                      const std::stop_token& stop);

}  // namespace mapjoin::apps
