// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <tests/apps/command.hpp>
#include <tests/mpi/kill.hpp>

namespace mapjoin::testing {
namespace {

TEST(KilledRank, EndsAllAndLeavesNoHalfOfAMap) {
  const TemporaryFolder folder;
  const std::string log = (folder.path() / "log.g2o").string();
  const std::filesystem::path map = folder.path() / "map.g2o";
  ASSERT_EQ(call({"simulate", "--poses", "20000", "-o", log, "--quiet"}).exit_code, 0);
  for (const double seconds : {0.0, 0.05, 0.15, 0.3, 0.5}) {
    const bool was_done = kill_one_of_two({"run", log, "-o", map.string()}, 1, [&](const auto&) { sleep_for(seconds); });
    EXPECT_EQ(std::filesystem::exists(map), was_done) << seconds;
    std::filesystem::remove(map);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << seconds;
  }
}

}  // namespace
}  // namespace mapjoin::testing
