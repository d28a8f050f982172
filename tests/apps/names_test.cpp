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

}  // namespace
}  // namespace mapjoin::testing
