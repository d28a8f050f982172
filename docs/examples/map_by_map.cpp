// SPDX-License-Identifier: BSD-3-Clause
// map_by_map LOG: local maps joined one by one, the estimate at its optimum after each; how certain the last pose then is.
#include <iostream>
#include <mapjoin/mapjoin.hpp>
#include <variant>

int main(int argc, char** argv) {
  using namespace mapjoin;
  const auto read = open_log(argc > 1 ? argv[1] : "log.g2o");
  if (!read || !std::holds_alternative<Log<2>>(*read)) {
    std::cerr << (read ? "the log is not in the plane" : read.error().message) << '\n';
    return 1;
  }
  const auto& log = std::get<Log<2>>(*read);

  Split segments = split(log, {SplitRule::kPoses, 10.0});
  const auto built = build_local_maps(log, segments, BuildOptions{});
  if (!built) return 1;

  IncrementalJoin<2> joined;
  std::size_t added = 0;
  for (const SubmapUpdate<2>& update : submap_updates_of(log, segments, built->maps)) {
    const auto step = joined.add(update);
    if (!step) return 1;
    if (++added % 25 == 0) std::cout << added << " maps: chi2 " << step->chi2 << " over " << step->dof << '\n';
  }
  const PoseId last = log.poses.back();
  if (const auto covariance = joined.covariance(last)) {
    std::cout << to_string(last) << ": " << std::sqrt(covariance->topLeftCorner<2, 2>().trace()) << " m\n";
  }
}
