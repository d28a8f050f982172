// SPDX-License-Identifier: BSD-3-Clause
// The local maps of one log built in parts, as several machines would, and joined.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <mapjoin/model/lists.hpp>
#include <tests/apps/command.hpp>
#include <tests/support/data.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

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

TEST_F(BuildInParts, StoresOfDifferentWeightsAreRefused) {
  const std::string one = build("1/2");
  const std::string other = path("identity.maps");
  ASSERT_EQ(call({"build", log, "-o", other, "--covariance", "identity", "--part", "2/2", "--poses-per-map", "25"}).exit_code,
            0);
  const Ended ended = call({"join", one, other});
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.err, HasSubstr(one + " has weights of --covariance original and " + other +
                                   " of --covariance identity: build both with the same"));
}

TEST_F(BuildInParts, PartsOfDifferentLogsAreNotTwoRobots) {
  const std::string first = build("1/2");
  const std::string second = build("2/2");
  std::ofstream(path("grown.g2o")) << content_of(log) << "EDGE_SE2 0 999 1 0 0 1 0 0 1 0 1\n";
  log = path("grown.g2o");
  const std::string grown = path("grown.maps");
  ASSERT_EQ(call({"build", log, "-o", grown, "--part", "2/2", "--poses-per-map", "25"}).exit_code, 0);
  const Ended ended = call({"join", first, grown});
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.err, HasSubstr(first + " and " + grown + " have parts 1/2 and 2/2 of the local maps of different logs"));
  EXPECT_THAT(ended.err, HasSubstr("build all parts from the same log with the same options, or give all parts of each log"));
  const Ended three = call({"join", grown, first, second});
  EXPECT_THAT(three.err, HasSubstr("have parts 2/2 and 1/2")) << "one of the grown log, all of the other";
  const std::string all = path("all.maps");
  ASSERT_EQ(call({"build", log, "-o", all, "--poses-per-map", "25"}).exit_code, 0);
  const Ended whole = call({"join", all, first});
  EXPECT_EQ(whole.exit_code, 3);
  EXPECT_THAT(whole.err, HasSubstr("have parts 1/1 and 1/2")) << "all of the grown log, one of the other";
}

TEST_F(BuildInParts, AllPartsOfEachOfTwoRobotsAreJoined) {
  const std::vector<std::string> one = {build("1/2"), build("2/2")};
  log = path("other.g2o");
  ASSERT_EQ(call({"simulate", "--poses", "300", "--seed", "9", "-o", log}).exit_code, 0);
  const std::vector<std::string> other = {build("1/3"), build("2/3"), build("3/3")};
  const auto checked = [&](std::vector<std::string> stores) {
    append(stores, one);
    stores.insert(stores.begin(), {"join", "--features", "shared"});
    return call(stores);
  };
  EXPECT_EQ(checked(other).exit_code, 0);
  EXPECT_EQ(checked({other[0], other[2]}).exit_code, 3);
}

TEST_F(BuildInParts, APartSaysWhichOneItIs) {
  EXPECT_THAT(call({"info", build("2/3")}).out, HasSubstr("part         2 of 3\n"));
  EXPECT_THAT(call({"info", build("1/1")}).out, Not(HasSubstr("\npart ")));
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
