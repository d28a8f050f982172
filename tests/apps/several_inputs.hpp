// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Two logs for one call.

#include <gtest/gtest.h>

#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {

class SeveralInputs : public ::testing::Test {
 protected:
  /// Writes the two halves of the bundled log, without the odometry between them, each with pose ids of its own.
  void SetUp() override {
    const auto whole = std::get<Log<2>>(open_log(kBundledLog).value());
    LogBuilder<2> first("a");
    LogBuilder<2> second("b");
    const PoseIndex cut = 500;
    const auto id = [&](PoseIndex pose) { return PoseId{0, (pose < cut ? pose : PoseIndex(pose - cut.value)).position()}; };
    for (const auto& edge : whole.edges()) {
      if ((edge.base < cut) != (edge.target < cut)) continue;
      (edge.base < cut ? first : second).add_pose_edge(id(edge.base), id(edge.target), edge.measured, edge.information);
    }
    for (const auto& seen : whole.observations()) {
      (seen.base < cut ? first : second)
          .add_observation(id(seen.base), whole.features[seen.target], seen.measured, seen.information);
    }
    ASSERT_TRUE(write_log(std::move(first).finish().value(), LogFormat::kG2o, a));
    ASSERT_TRUE(write_log(std::move(second).finish().value(), LogFormat::kG2o, b));
  }

  TemporaryFolder folder;
  std::string a = (folder.path() / "a.g2o").string();
  std::string b = (folder.path() / "b.g2o").string();
};

}  // namespace mapjoin::testing
