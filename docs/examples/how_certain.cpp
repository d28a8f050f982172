// SPDX-License-Identifier: BSD-3-Clause
// how_certain LOG: joint and relative covariances of a map in the plane.
#include <array>
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

  RunOptions options;
  options.covariances = true;
  const auto result = run(log, options);
  if (!result || !result->covariances) return 1;
  const MapCovariances<2>& covariances = *result->covariances;

  const PoseIndex last = indices(log.poses).last - 1;
  const std::array<PoseOrFeature, 2> ends = {last, last - 1};
  const auto joint = covariances.joint(ends);                       // 6 x 6: x y φ of the one, then of the other
  const auto relative = covariances.relative_pose(last - 1, last);  // 3 x 3: of the last step, in its own frame
  if (!joint || !relative) return 1;
  std::cout << "in the map " << std::sqrt(joint->topLeftCorner<2, 2>().trace()) << " m, to the pose before "
            << std::sqrt(relative->topLeftCorner<2, 2>().trace()) << " m\n";
}
