// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/data.hpp>
#include <tests/support/places.hpp>
#include <variant>

namespace mapjoin {
namespace {

/// Expects the optimum at every `every`-th of the local maps of 10 poses that are joined one by one.
void expect_optimal(const std::filesystem::path& path, std::size_t every) {
  const auto log = open_log(path, {});
  ASSERT_TRUE(log) << log.error().message;
  std::visit([&](const auto& any) { testing::expect_optimal_at_every_kth_step(testing::parts_of_log(any, 10.0), every); },
             *log);
}

TEST(IncrementalData, BundledWorldsAreOptimalAtEveryStep) {
  expect_optimal(testing::kBundledData / "manhattan2d.g2o", 1);
  expect_optimal(testing::kBundledData / "manhattan3d.g2o", 1);
}

TEST(IncrementalData, VictoriaParkIsOptimalAllTheWay) {
  expect_optimal(testing::data_file("vicpark-6898/vicpark6898.g2o.gz"), 69);
}

TEST(IncrementalData, PoseGraphsAreOptimalAllTheWay) {
  expect_optimal(testing::data_file("pose-graphs-2d/intel.g2o.gz"), 20);
  expect_optimal(testing::data_file("pose-graphs-3d/parking-garage.g2o.gz"), 40);
}

}  // namespace
}  // namespace mapjoin
