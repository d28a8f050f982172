// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the command says on its standard streams.

#include <chrono>
#include <cstddef>
#include <functional>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::apps {

/// kCannotWrite where the stream cannot take it. A reader that has gone away has had all it wanted: no error.
Expected<void> write_stdout(std::string_view text);

/// One sentence on standard error, after the command's name.
void say(const std::string& sentence);

/// Lines that end between words, of at most `width` characters where no word is longer.
std::vector<std::string> wrapped(const std::string& text, std::size_t width);

/// Aligned lines of a name and what there is to say of it.
class Lines {
 public:
  void add(std::string_view name, std::string_view text);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// How far the work is: one updating line per stage on standard error, where that is a terminal.
class Progress {
 public:
  /// What is done, and what there is to do.
  using Count = std::function<void(std::size_t, std::size_t)>;

  explicit Progress(bool wanted);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { close(); }

  /// Whether anybody looks.
  bool is_shown() const { return is_shown_; }
  void show(const std::string& what, std::size_t done, std::size_t to_do);
  /// show() of these things; must not outlive this. Empty where nobody looks.
  Count count(const std::string& what);
  /// Ends the line, so that something else can be written.
  void close();

 private:
  bool is_shown_;
  std::string what_;  ///< The line that is open is of; empty: none is.
  std::chrono::steady_clock::time_point last_;
};

}  // namespace mapjoin::apps
