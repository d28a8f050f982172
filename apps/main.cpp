// SPDX-License-Identifier: BSD-3-Clause
// The `mapjoin` command.

#include <apps/console.hpp>
#include <apps/process.hpp>
#include <apps/program.hpp>
#include <cstdlib>

namespace mapjoin::apps {
namespace {

ExitCode main(int argc, char** argv) {
  if (const auto ready = prepare_process(); !ready) {
    say(ready.error().message);
    std::_Exit(static_cast<int>(ExitCode::kTooLarge));  // OpenBLAS would wait for its threads, which ask for memory for ever
  }
  const auto work = [&] {
    const Interruption interruption;
    return parse_and_run(command_line(), argc, argv, interruption.token());
  };
  return with_errors_told(work, say);
}

}  // namespace
}  // namespace mapjoin::apps

int main(int argc, char** argv) {
  return static_cast<int>(mapjoin::apps::main(argc, argv));
}
