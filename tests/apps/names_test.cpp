// SPDX-License-Identifier: BSD-3-Clause
// The names of poses and features in the files that commands write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tests/apps/command.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class NamesTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  TemporaryFolder folder;
};

TEST_F(NamesTest, OfATruthInATableAreThoseOfTheLogInG2o) {
  ASSERT_EQ(call({"simulate", "--poses", "30", "-o", path("log.g2o"), "--truth", path("truth.csv"), "--quiet"}).exit_code, 0);
  EXPECT_THAT(content_of(path("log.g2o")), HasSubstr("\nEDGE_SE2_XY 0 100 "));
  EXPECT_THAT(content_of(path("truth.features.csv")), StartsWith("feature,x,y\n100,"));
}

TEST_F(NamesTest, ThatG2oCannotKeepAreTold) {
  const std::string log =
      folder.file("log.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 0 1 2 1 1 0 1\nEDGE_SE2_XY 1 1 1 1 1 0 1\n").string();
  const std::string said = "a map in g2o has one numbering: features are numbered from 10 on, apart from poses; a table (.csv)";
  ASSERT_EQ(call({"build", log, "-o", path("maps"), "--quiet"}).exit_code, 0);
  for (const auto& [command, input] : {std::pair("run", log), std::pair("solve", log), std::pair("join", path("maps"))}) {
    EXPECT_THAT(call({command, input, "-o", path("map.g2o")}).out, HasSubstr(said)) << command;
    EXPECT_THAT(call({command, input, "-o", path("map.csv")}).out, Not(HasSubstr("one numbering"))) << command;
  }
  EXPECT_THAT(call({"run", log, "-o", path("folder")}).out, HasSubstr(said)) << "of its map.g2o";
  const std::string truth = folder.file("truth.g2o", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 1 2 1\n").string();
  EXPECT_THAT(call({"error", path("map.g2o"), truth}).out, HasSubstr("1 of 1 feature is not in the truth, by name"));
  EXPECT_THAT(call({"run", log, "--truth", truth}).out, Not(HasSubstr("not in the truth")));
}

}  // namespace
}  // namespace mapjoin::testing
