// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/store.hpp>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

/// Expects a line of `text` to be this name and these words, with any number of spaces between them.
void expect_line(const std::string& text, const std::string& name, const std::string& words) {
  EXPECT_THAT(text, ::testing::ContainsRegex("(^|\n)" + name + " +" + words + "\n"));
}

TEST(Info, TellsWhatALogHas) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog + "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\nFIX 0\n");
  const std::string text = call({"info", log.string()}).out;
  expect_line(text, "kind", "log");
  expect_line(text, "dimension", "2");
  expect_line(text, "poses", "3, pose 0 to pose 2");
  expect_line(text, "features", "1, feature 7 to feature 7");
  expect_line(text, "odometry", "2");
  expect_line(text, "closures", "1");
  expect_line(text, "observations", "2");
  expect_line(text, "fixed poses", "1");
  expect_line(text, "stamps", "none");
}

TEST(Info, RefusesALogThatIsGivenTwiceAsARunDoes) {
  const Ended ended = call({"info", kBundledLog, kBundledLog});
  expect_failure(ended, 2, kBundledLog + " is given twice: leave one out");
  EXPECT_EQ(call({"run", kBundledLog, kBundledLog}).err, ended.err);
}

TEST(Info, TellsAStoreFromALog) {
  const TemporaryFolder folder;
  const std::string store = (folder.path() / "maps").string();
  ASSERT_EQ(call({"build", kBundledLog, "-o", store, "--poses-per-map", "50"}).exit_code, 0);
  const std::string text = call({"info", store}).out;
  expect_line(text, "kind", "store of local maps and their log");
  expect_line(text, "local maps", "20 of 20 segments of up to 50 steps");
  expect_line(text, "poses", "1000, pose 0 to pose 999");
}

TEST(Info, TellsStampsToTheNanosecond) {
  const TemporaryFolder folder;
  Log<2> log = std::get<Log<2>>(*open_log(folder.file("log.g2o", kSmallLog)));
  log.stamps_ns = {1'600'000'000'123'456'789, 1'600'000'001'000'000'000, 1'600'000'002'000'000'001};
  const auto store = folder.path() / "maps";
  auto writer = StoreWriter<2>::open(store, log, {{0, 2, false}}, "");
  ASSERT_TRUE(writer && writer->finish());
  expect_line(call({"info", store.string()}).out, "stamps", "1600000000.123456789 s to 1600000002.000000001 s");
  const auto two = folder.file("two.csv", "session,pose,x,y,phi,stamp_ns\n0,0,0,0,0,5000000000\n1,0,0,0,0,2000000000\n");
  expect_line(call({"info", two.string()}).out, "stamps", "2.000000000 s to 5.000000000 s");
}

TEST(Info, TellsWhatASetOfLocalMapsHas) {
  const TemporaryFolder folder;
  // A local map from pose 0 to pose 1 that sees feature 7.
  std::string map = "0\n5\n-1 1\n-1 0\n-1 0\n7 2\n7 1\n";
  for (int row = 0; row < 5; ++row) {
    for (int col = 0; col < 5; ++col) map += row == col ? "1 " : "0 ";
    map += "\n";
  }
  folder.file("localmap_1.txt", map);
  const Ended ended = call({"info", folder.path().string()});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  expect_line(ended.out, "kind", "set of local maps");
  expect_line(ended.out, "local maps", "1");
  expect_line(ended.out, "features", "1, feature 7 to feature 7; 1 in all maps together");
}

}  // namespace
}  // namespace mapjoin::testing
