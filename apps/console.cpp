// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <apps/console.hpp>
#include <cerrno>
#include <cstdio>
#include <mapjoin/io/files/system_call.hpp>
#include <sstream>
#include <system_error>

namespace mapjoin::apps {
namespace {

constexpr std::chrono::milliseconds kPause(100);  // Least time between two updates of a line.

}  // namespace

Expected<void> write_stdout(std::string_view text) {
  const int failure = write_all(STDOUT_FILENO, text);
  if (failure == 0 || failure == EPIPE) return {};
  return call_failed("standard output", failure, ErrorKind::kCannotWrite);
}

bool is_stdout(const std::filesystem::path& path) {
  struct ::stat named {};
  struct ::stat out {};
  if (path == "-") return true;
  if (::stat(path.c_str(), &named) != 0 || ::fstat(STDOUT_FILENO, &out) != 0) return false;
  return named.st_dev == out.st_dev && named.st_ino == out.st_ino;
}

bool is_stream(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  return is_stdout(path) || (exists(status) && !is_regular_file(status) && !is_directory(status));
}

void say(const std::string& sentence) {
  std::fputs(fmt::format("mapjoin: {}\n", sentence).c_str(), stderr);
}

void say_not_written(const std::filesystem::path& file) {
  say(file.string() + ": was there before, and this call did not write it; unless it is of a map that you keep, remove it");
}

std::vector<std::string> wrapped(const std::string& text, std::size_t width) {
  std::istringstream words(text);
  std::vector<std::string> lines;
  for (std::string word; words >> word;) {
    if (!lines.empty() && lines.back().size() + 1 + word.size() <= width) {
      lines.back() += " " + word;
    } else {
      lines.push_back(word);
    }
  }
  return lines;
}

void Lines::add(std::string_view name, std::string_view text) {
  text_ += fmt::format("{:<13}{}\n", name, text);
}

Progress::Progress(bool wanted) : is_shown_(wanted && ::isatty(STDERR_FILENO) == 1) {}

Progress::Count Progress::count(const std::string& what) {
  if (!is_shown_) return nullptr;
  return [this, what](std::size_t done, std::size_t to_do) { show(what, done, to_do); };
}

void Progress::show(const std::string& what, std::size_t done, std::size_t to_do) {
  const auto now = std::chrono::steady_clock::now();
  if (what_ == what && done < to_do && now - last_ < kPause) return;
  if (what_ != what) close();
  what_ = what;
  last_ = now;
  const std::string count = to_do > 1 ? fmt::format(" {} of {}", done, to_do) : "";
  std::fputs(fmt::format("\r{}{}", what, count).c_str(), stderr);
}

void Progress::close() {
  if (!what_.empty()) std::fputs("\n", stderr);
  what_.clear();
}

}  // namespace mapjoin::apps
