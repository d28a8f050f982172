// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Reports of the steps of a followed log: a line for people, and a line of JSON for programs.

#include <cstdio>
#include <filesystem>
#include <mapjoin/join/incremental/robust_incremental_join.hpp>
#include <memory>
#include <optional>

namespace mapjoin::apps {

/// The first and last pose of consecutive maps.
struct Way {
  PoseId begin;
  PoseId end;
};

/// A step of the join: maps that were added at once, or what came late.
struct Step {
  std::size_t first = 0;  ///< Number of its first map, from 1; there are `count`.
  std::size_t count = 0;
  std::optional<Way> way = {};  ///< nullopt if there is no map, as all of it came late.
  RobustlyAdded done = {};
  std::optional<std::size_t> left_out = {};  ///< Closures left out after it; nullopt without --robust.
  double seconds = 0.0;                      ///< CPU time.
};

/// Reports each step: a line for people on standard error, if that is a terminal, and a line of JSON for programs.
class StepReport {
 public:
  /// Opens `path`, as of FollowOptions::steps; kCannotWrite if the file cannot be made. It is emptied at the first step, since
  /// a log may have none, and grows line by line, for others to follow.
  StepReport(const std::filesystem::path& path, bool quiet);

  void add(const Step& step);

 private:
  void begin();

  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  std::filesystem::path path_;
  File file_{nullptr, std::fclose};
  bool is_shown_;
  bool is_begun_ = false;
};

}  // namespace mapjoin::apps
