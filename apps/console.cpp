// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <apps/console.hpp>
#include <cerrno>
#include <cstdio>
#include <mapjoin/io/files/system_call.hpp>

namespace mapjoin::apps {

Expected<void> write_stdout(std::string_view text) {
  const int failure = write_all(STDOUT_FILENO, text);
  if (failure == 0 || failure == EPIPE) return {};
  return call_failed("standard output", failure, ErrorKind::kCannotWrite);
}

void say(const std::string& sentence) {
  std::fputs(fmt::format("mapjoin: {}\n", sentence).c_str(), stderr);
}

void Lines::add(std::string_view name, std::string_view text) {
  text_ += fmt::format("{:<13}{}\n", name, text);
}

}  // namespace mapjoin::apps
