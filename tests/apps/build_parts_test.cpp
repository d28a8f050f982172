// SPDX-License-Identifier: BSD-3-Clause
// The local maps of one log built in parts, as several machines would, and joined.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tests/apps/command.hpp>
#include <tests/support/data.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

class BuildInParts : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  std::string build(const std::string& part, const std::string& poses_per_map = "25") const {
    const std::string store = path(fmt::format("{}_of_{}_{}.maps", part.front(), part.back(), poses_per_map));
    EXPECT_EQ(call({"build", log, "-o", store, "--part", part, "--poses-per-map", poses_per_map}).exit_code, 0);
    return store;
  }

  TemporaryFolder folder;
  std::string log = kBundledLog;
};

TEST_F(BuildInParts, AllPartsTogetherAreTheStoreOfTheWhole) {
  const std::string whole = path("whole.maps");
  ASSERT_EQ(call({"build", log, "-o", whole, "--poses-per-map", "25"}).exit_code, 0);
  ASSERT_EQ(call({"join", whole, "-o", path("whole.g2o")}).exit_code, 0);
  ASSERT_EQ(call({"join", build("3/3"), build("1/3"), build("2/3"), "-o", path("parts.g2o")}).exit_code, 0);
  EXPECT_EQ(content_of(path("parts.g2o")), content_of(path("whole.g2o")));
}

TEST_F(BuildInParts, WhatNoPartHasIsJoinedAsItWasObserved) {
  const auto whole = report_of({"run", log});
  const auto parts = report_of({"join", build("1/3"), build("2/3")});
  EXPECT_LT(parts["local_maps"]["count"], 40);
  EXPECT_GT(parts["local_maps"]["count"], 20);
  EXPECT_NEAR(parts["chi2"], whole["chi2"], 1e-6 * whole["chi2"].get<double>());
}

TEST_F(BuildInParts, PartsThatAreCutInDifferentWaysAreRefused) {
  const Ended ended = call({"join", build("1/2"), build("2/2", "20")});
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.err, HasSubstr("cut in different ways: build all parts with the same options"));
}

TEST_F(BuildInParts, APartIsOneOfSoMany) {
  for (const char* wrong : {"0/3", "4/3", "2", "2/", "/2", "a/b", "1/3/4", "-1/3"}) {
    const Ended ended = call({"build", log, "-o", path("x.maps"), "--part", wrong});
    EXPECT_EQ(ended.exit_code, 2) << wrong;
    EXPECT_THAT(ended.err, HasSubstr("not K/N with K from 1 to N")) << wrong;
  }
}

}  // namespace
}  // namespace mapjoin::testing
