// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <apps/exit_code.hpp>
#include <apps/truncated_input.hpp>
#include <csignal>
#include <string_view>

namespace mapjoin::apps {
namespace {

extern "C" void on_missing_page(int) {
  constexpr std::string_view kSentence = "mapjoin: an input file was cut short while it was read\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kSentence.data(), kSentence.size());
  ::_exit(static_cast<int>(ExitCode::kBadInput));
}

}  // namespace

void end_on_truncated_input() {
  std::signal(SIGBUS, on_missing_page);
}

}  // namespace mapjoin::apps
