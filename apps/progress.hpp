// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far the work is, on a terminal: one updating line per stage.

#include <chrono>
#include <cstddef>
#include <functional>
#include <mapjoin/join/run.hpp>
#include <optional>

namespace mapjoin::apps {

/// Writes to standard error, and only where that is a terminal.
class Progress {
 public:
  explicit Progress(bool wanted);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { close(); }

  /// For RunOptions; must not outlive this. Empty where nobody looks.
  std::function<void(Stage, std::size_t, std::size_t)> callback();
  /// Ends the line, so that something else can be written.
  void close();

 private:
  void show(Stage stage, std::size_t done, std::size_t to_do);

  bool shown_ = false;
  std::optional<Stage> stage_;  ///< Of the line that is open.
  std::chrono::steady_clock::time_point last_;
};

}  // namespace mapjoin::apps
