// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <apps/progress.hpp>
#include <cstdio>

namespace mapjoin::apps {
namespace {

constexpr std::chrono::milliseconds kPause(100);  // Between two updates of a line.

const char* word(Stage stage) {
  switch (stage) {
    case Stage::kBuild:
      return "local maps";
    case Stage::kJoin:
      return "joins";
    case Stage::kRecover:
      return "recovering";
    case Stage::kPolish:
      return "polishing";
  }
  return "";
}

}  // namespace

Progress::Progress(bool wanted) : shown_(wanted && ::isatty(STDERR_FILENO) == 1) {}

std::function<void(Stage, std::size_t, std::size_t)> Progress::callback() {
  if (!shown_) return nullptr;
  return [this](Stage stage, std::size_t done, std::size_t to_do) { show(stage, done, to_do); };
}

void Progress::show(Stage stage, std::size_t done, std::size_t to_do) {
  const auto now = std::chrono::steady_clock::now();
  if (stage_ == stage && done < to_do && now - last_ < kPause) return;
  if (stage_ != stage) close();
  stage_ = stage;
  last_ = now;
  const std::string count = to_do > 1 ? fmt::format(" {} of {}", done, to_do) : "";
  std::fputs(fmt::format("\r{}{}", word(stage), count).c_str(), stderr);
}

void Progress::close() {
  if (stage_) std::fputs("\n", stderr);
  stage_.reset();
}

}  // namespace mapjoin::apps
