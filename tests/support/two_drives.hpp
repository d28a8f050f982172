// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Two drives along one straight road, tied to each other by closures alone.

#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <vector>

namespace mapjoin::testing {

/// A closure from a pose of the first drive to one of the second, and its error sideways (m).
struct Crossing {
  std::uint64_t first = 0;
  std::uint64_t second = 0;
  double wrong_by = 0.0;
};

/// Two sessions of `poses` poses in steps of 1 m. Odometry and closures state a standard deviation of 0.01 (m, rad) of every
/// coordinate; the standard deviation of their errors is `errors` times as large.
template <int Dim>
Log<Dim> two_drives(int poses, const std::vector<Crossing>& crossings, double errors = 0.0) {
  constexpr double kDeviation = 0.01;
  RandomStream random(1, 0);
  const auto measured = [&](double along, double sideways) {
    PoseVector<Dim> error;
    for (double& e : error) e = errors * kDeviation * random.normal();
    Pose<Dim> pose;
    pose.translation.template head<2>() = Point<2>(along, sideways);
    return retract(pose, error);
  };
  const PoseMatrix<Dim> W = PoseMatrix<Dim>::Identity() / (kDeviation * kDeviation);
  LogBuilder<Dim> builder("two drives");
  for (const std::uint32_t session : {0U, 1U}) {
    builder.add_pose({session, 0});
    for (std::uint64_t k = 1; k < static_cast<std::uint64_t>(poses); ++k) {
      builder.add_pose_edge({session, k - 1}, {session, k}, measured(1.0, 0.0), W);
    }
  }
  for (const auto& [first, second, wrong_by] : crossings) {
    const double along = static_cast<double>(second) - static_cast<double>(first);
    builder.add_pose_edge({0, first}, {1, second}, measured(along, wrong_by), W);
  }
  return std::move(builder).finish().value();
}

}  // namespace mapjoin::testing
