// SPDX-License-Identifier: BSD-3-Clause
// progress LOG: a run that reports its progress, and is stopped half-way.
#include <iostream>
#include <mapjoin/mapjoin.hpp>
#include <variant>

int main(int argc, char** argv) {
  const auto log = mapjoin::open_log(argc > 1 ? argv[1] : "log.g2o");
  if (!log) {
    std::cerr << log.error().message << '\n';
    return 1;
  }
  std::stop_source stop;
  mapjoin::RunOptions options;
  options.progress = [&stop](mapjoin::Stage stage, std::size_t done, std::size_t all) {
    if (stage != mapjoin::Stage::kBuild) return;
    if (2 * done >= all) stop.request_stop();  // From any thread: here as soon as half of the maps are built.
  };
  const auto run = [&](const auto& any) {
    const auto result = mapjoin::run(any, options, stop.get_token());
    if (!result && result.error().kind == mapjoin::ErrorKind::kInterrupted) std::cout << "stopped half-way\n";
  };
  std::visit(run, *log);
}
