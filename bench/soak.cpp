// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_soak: any number of local maps joined one by one, with a snapshot after each: CPU time and memory as they add up.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <memory>
#include <numeric>
#include <tests/support/corridor.hpp>
#include <vector>

namespace mapjoin {
namespace {

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void print_row(std::size_t maps, std::vector<double> seconds, double bytes) {
  std::sort(seconds.begin(), seconds.end());
  const double sum = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  fmt::print("| {} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.0f} |\n", maps, 1e3 * seconds[seconds.size() / 2],
             1e3 * sum / static_cast<double>(seconds.size()), 1e3 * seconds.back(), bytes / 1e6,
             bytes / static_cast<double>(maps));
  std::fflush(stdout);
}

/// Prints a row after each tenth of the maps, with the times of that tenth.
void table(std::size_t maps) {
  fmt::print("| maps | median (ms) | mean (ms) | most (ms) | memory (MB) | bytes per map |\n|---|---|---|---|---|---|\n");
  const double before = testing::bytes_in_use();
  {
    testing::Corridor corridor;
    IncrementalJoin<2> joined;
    std::shared_ptr<const JoinedSnapshot<2>> snapshot;
    std::vector<double> seconds;
    for (std::size_t k = 1; k <= maps; ++k) {
      SubmapUpdate<2> update = corridor.next();
      const double start = cpu_seconds();
      joined.add(std::move(update)).value();
      snapshot = joined.snapshot();
      seconds.push_back(cpu_seconds() - start);
      if (k * 10 / maps == (k - 1) * 10 / maps) continue;
      print_row(k, std::exchange(seconds, {}), testing::bytes_in_use() - before);
    }
  }
  fmt::print("\n{:.3f} MB are left of it at the end\n", (testing::bytes_in_use() - before) / 1e6);
}

}  // namespace
}  // namespace mapjoin

int main(int argc, char** argv) {
  std::size_t maps = 100'000;
  CLI::App app("A long corridor joined map by map: CPU time and memory as they add up");
  app.add_option("--maps", maps, "So many maps [100000]")->check(CLI::Range(10, 100'000'000));
  CLI11_PARSE(app, argc, argv);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  mapjoin::table(maps);
}
