// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <apps/console.hpp>
#include <cerrno>
#include <cstdio>
#include <system_error>

namespace mapjoin::apps {

Expected<void> write_stdout(std::string_view text) {
  while (!text.empty()) {
    const ::ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written >= 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno == EPIPE) {
      return {};
    } else if (errno != EINTR) {
      return tl::unexpected(
          Error{ErrorKind::kCannotWrite, fmt::format("standard output: {}", std::generic_category().message(errno))});
    }
  }
  return {};
}

void say(const std::string& sentence) {
  std::fputs(fmt::format("mapjoin: {}\n", sentence).c_str(), stderr);
}

void Lines::add(std::string_view name, std::string_view text) {
  text_ += fmt::format("{:<13}{}\n", name, text);
}

}  // namespace mapjoin::apps
