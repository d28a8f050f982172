// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far the work is, on a terminal: one updating line per stage.

#include <chrono>
#include <cstddef>
#include <functional>
#include <mapjoin/join/run.hpp>
#include <string>

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
  /// For studies, with their own words: what they are busy with, what is done of it, and what there is to do.
  std::function<void(const std::string&, std::size_t, std::size_t)> callback_in_words();
  /// Ends the line, so that something else can be written.
  void close();

 private:
  void show(const std::string& what, std::size_t done, std::size_t to_do);

  bool shown_ = false;
  std::string what_;  ///< The line that is open is of; empty: none is.
  std::chrono::steady_clock::time_point last_;
};

}  // namespace mapjoin::apps
