// SPDX-License-Identifier: BSD-3-Clause
// what_is_wrong LOG: whether a map fits its measurements, and the map without those that contradict the others.
#include <iostream>
#include <mapjoin/mapjoin.hpp>
#include <variant>

void print(const mapjoin::RunResult<2>& result) {
  std::cout << to_string(result.fit.verdict) << ": chi2 " << result.chi2 << " over " << result.dof << '\n';
}

int main(int argc, char** argv) {
  using namespace mapjoin;
  const auto read = open_log(argc > 1 ? argv[1] : "log.g2o");
  if (!read || !std::holds_alternative<Log<2>>(*read)) {
    std::cerr << (read ? "the log is not in the plane" : read.error().message) << '\n';
    return 1;
  }
  const auto& log = std::get<Log<2>>(*read);

  const auto believed = run(log, RunOptions{});
  if (!believed) return 1;
  print(*believed);

  const auto inliers = find_inliers(log, RobustOptions{});
  if (!inliers) return 1;
  for (const Rejected& rejected : inliers->rejected) {
    std::cout << to_string(rejected.misfit.kind) << " from " << to_string(log.poses[rejected.misfit.from])
              << " is left out: " << to_string(rejected.why) << '\n';
  }
  const auto trusted = run(inliers->input, RunOptions{});
  if (!trusted) return 1;
  print(*trusted);
}
