// SPDX-License-Identifier: BSD-3-Clause
// Public multi-robot sets, read from one file for each robot.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <tests/support/data.hpp>
#include <tests/support/same_log.hpp>

namespace mapjoin::testing {
namespace {

TEST(SeveralData, FilesOfRobotsMakeTheGraphOfAllWithEachEdgeOnce) {
  std::vector<std::filesystem::path> files;
  for (int k = 0; k < 4; ++k) files.push_back(data_file("robots/blocks_world_4robots/" + std::to_string(k) + ".g2o"));
  const auto all = std::get<Log<3>>(open_logs(files).value());
  const auto whole = std::get<Log<3>>(open_log(data_file("robots/blocks_world_4robots/fullGraph.g2o")).value());
  EXPECT_EQ(all.edges().size(), whole.edges().size());
  EXPECT_EQ(all.skipped.at("copies of edges in another file"), 32);
  ASSERT_EQ(all.poses.size(), whole.poses.size());
  EXPECT_EQ(std::get<Log<3>>(open_logs(files, {}, {.keep_copies = true}).value()).edges().size(), 176u);
}

TEST(SeveralData, AFileAloneNamesThePoseThatAnotherHas) {
  const auto path = data_file("robots/blocks_world_4robots/0.g2o");
  EXPECT_THAT(open_log(path).error().message,
              ::testing::ContainsRegex("declares vertices, but not pose [b-d][0-9]+; give the file"));
  EXPECT_TRUE(open_log(path, {.undeclared = Undeclared::kSkipped}));
}

}  // namespace
}  // namespace mapjoin::testing
