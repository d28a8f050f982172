// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What each added map did: a line for people on a terminal, a line of JSON for programs.

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/ids.hpp>
#include <memory>
#include <string>

namespace mapjoin::apps {

/// The parts that were added at once.
struct Step {
  std::size_t first = 0;  ///< The number of its first part, from 1, and how many there are.
  std::size_t count = 1;
  PoseId begin, end;
  AddedPart added;
  double seconds = 0.0;  ///< CPU time.
};

class StepReport {
 public:
  /// `path`: as FollowOptions::steps. Lines for people go to standard error where that is a terminal, unless `quiet`.
  /// kCannotWrite where the file cannot be made; it grows line by line, for others to follow.
  static Expected<StepReport> open(const std::filesystem::path& path, bool quiet);

  Expected<void> add(const Step& step);

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  StepReport(std::filesystem::path path, File file, bool is_shown);

  std::filesystem::path path_;
  File file_;  // null: none
  bool is_shown_;
};

}  // namespace mapjoin::apps
