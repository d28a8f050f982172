// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Output of the command on its standard streams.

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::apps {

/// Writes to standard output; kCannotWrite if that fails, except because the reader has gone away.
Expected<void> write_stdout(std::string_view text);

/// True if an output goes to standard output: "-", or a path that leads there, such as /dev/stdout.
bool is_stdout(const std::filesystem::path& path);

/// True if an output is a device, a pipe or standard output: no file that others could lie beside.
bool is_stream(const std::filesystem::path& path);

/// One sentence on standard error, after the command's name.
void say(const std::string& sentence);

/// Says that a file was there before, and that this call did not write it: it may be of a map that the user keeps.
void say_not_written(const std::filesystem::path& file);

/// The text in lines broken between words, of at most `width` characters unless a word is longer.
std::vector<std::string> wrapped(const std::string& text, std::size_t width);

/// Aligned lines, each of a name and a text.
class Lines {
 public:
  void add(std::string_view name, std::string_view text);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// The progress of the work: one updating line per stage on standard error, if that is a terminal.
class Progress {
 public:
  /// Called with the numbers done and to do.
  using Count = std::function<void(std::size_t, std::size_t)>;

  explicit Progress(bool wanted);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { close(); }

  /// True if progress is wanted and standard error is a terminal.
  bool is_shown() const { return is_shown_; }
  void show(const std::string& what, std::size_t done, std::size_t to_do);
  /// A function that shows the count of `what`; must not outlive this. Empty if progress is not shown.
  Count count(const std::string& what);
  /// Ends the line, so that something else can be written.
  void close();

 private:
  bool is_shown_;
  std::string what_;  ///< What the open line counts; empty: none is open.
  std::chrono::steady_clock::time_point last_;
};

}  // namespace mapjoin::apps
