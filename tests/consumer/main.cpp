// SPDX-License-Identifier: BSD-3-Clause
// A user's program against the installed package.
#include <cstdio>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/version.hpp>

int main() {
  const mapjoin::Pose<3> step{{1.0, 0.0, 0.0}, mapjoin::Rotation<3>::exp({0.0, 0.0, 0.1})};
  const mapjoin::Pose<3> there_and_back = compose(step, inverse(step));
  std::printf("mapjoin %s: %s\n", mapjoin::kVersion.data(), to_string(mapjoin::PoseId{0, 7}).c_str());
  return there_and_back.translation.norm() < 1e-12 ? 0 : 1;
}
