// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log that is built edge by edge, with edges that can be told from each other.

#include <gtest/gtest.h>

#include <mapjoin/model/log_builder.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::testing {

template <typename D>
class BuiltLogTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Adds an edge that can be told from the others by `mark`, its first coordinate.
  void edge(PoseId base, PoseId target, double mark = 0.0) {
    Pose<kDim> measured;
    measured.translation[0] = mark;
    builder.add_pose_edge(base, target, measured, PoseMatrix<kDim>::Identity());
  }
  void observe(std::uint64_t pose, std::uint64_t feature, double mark = 0.0) {
    builder.add_observation({0, pose}, {feature}, mark * Point<kDim>::UnitX(), PointMatrix<kDim>::Identity());
  }
  Expected<Log<kDim>> finish() { return std::move(builder).finish(); }
  std::string message() { return finish().error().message; }

  LogBuilder<kDim> builder{"some.log"};
};

/// The marks of observations, in their order.
template <typename Observations>
std::vector<double> marks(const Observations& observations) {
  std::vector<double> result;
  for (const auto& o : observations) {
    if constexpr (requires { o.measured.translation; }) {
      result.push_back(o.measured.translation[0]);
    } else {
      result.push_back(o.measured[0]);
    }
  }
  return result;
}

}  // namespace mapjoin::testing
