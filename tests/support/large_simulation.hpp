// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The truth of sim-35188, a public simulation of 700 local maps.

#include <cmath>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <string>
#include <tests/support/data.hpp>
#include <tests/support/file_bytes.hpp>

namespace mapjoin::testing {

/// The truth at the poses of the set, the ends of its maps: pose k is step round(35187 k / 700). Features are named as the
/// beacons are.
inline Truth<2> truth_of_simulation(const SubmapSet<2>& set) {
  const auto read = [](const std::string& name) {
    const std::string bytes = bytes_of(data_file("sim-35188/" + name + ".mat"));
    return read_mat(bytes, name, {name}).value().at(name);
  };
  const Eigen::MatrixXd robot = read("store_robotTrue");
  const Eigen::MatrixXd beacons = read("store_beaconsTrue");
  Truth<2> truth;
  for (const PoseIndex k : indices(set.poses)) {
    const auto step = static_cast<Eigen::Index>(std::lround(35187.0 * k.value / 700.0));
    truth.poses.push_back(Pose<2>{robot.block<2, 1>(0, step), Rotation<2>(robot(2, step))});
  }
  truth.features.resize(set.features.size());
  for (Eigen::Index b = 0; b < beacons.rows(); ++b) {
    const FeatureId id{static_cast<std::uint64_t>(beacons(b, 0))};
    if (const auto f = IndexOf(set.features)(id)) truth.features[*f] = beacons.block<1, 2>(b, 1).transpose();
  }
  return truth;
}

}  // namespace mapjoin::testing
