// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <apps/progress.hpp>
#include <cstdio>

namespace mapjoin::apps {
namespace {

constexpr std::chrono::milliseconds kPause(100);  // Between two updates of a line.

}  // namespace

Progress::Progress(bool wanted) : shown_(wanted && ::isatty(STDERR_FILENO) == 1) {}

std::function<void(Stage, std::size_t, std::size_t)> Progress::callback() {
  if (!shown_) return nullptr;
  return [this](Stage stage, std::size_t done, std::size_t to_do) { show(to_string(stage), done, to_do); };
}

std::function<void(const std::string&, std::size_t, std::size_t)> Progress::callback_in_words() {
  if (!shown_) return nullptr;
  return [this](const std::string& what, std::size_t done, std::size_t to_do) { show(what, done, to_do); };
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
