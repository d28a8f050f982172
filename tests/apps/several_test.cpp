// SPDX-License-Identifier: BSD-3-Clause
// Several logs or stores in one call, each a session.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <tests/apps/several_inputs.hpp>
#include <tests/support/data.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(SeveralInputs, RunJoinsTwoLogsByTheirFeatures) {
  const auto joined = report_of({"run", a, b, "-o", (folder.path() / "map.csv").string()});
  EXPECT_EQ(joined["input"], a + " + " + b);
  EXPECT_EQ(joined["sessions"], 2);
  EXPECT_EQ(joined["poses"], 1000);
  EXPECT_NEAR(joined["chi2"], report_of({"solve", a, b})["chi2"], 1e-6 * joined["chi2"].get<double>());
  EXPECT_THAT(content_of(folder.path() / "map.csv"), HasSubstr("\n1,499,"));
}

TEST_F(SeveralInputs, MapsThatShareFeaturesAreJoinedWithoutTheirValues) {
  const auto map_of = [&](const std::string& log, const std::string& name) {
    const std::string map = (folder.path() / name).string();
    EXPECT_EQ(call({"solve", log, "-o", map}).exit_code, 0);
    return map;
  };
  const std::string first = map_of(a, "first.g2o");
  const std::string second = map_of(b, "second.g2o");
  const double chi2 = report_of({"solve", a, b})["chi2"];
  const auto solved = report_of({"solve", first, second});
  EXPECT_NEAR(solved["chi2"], chi2, 1e-6 * chi2);
  EXPECT_GT(solved["skipped"]["initial values, each in the frame of its file"], 1000);
  expect_failure(call({"solve", first, second, "--start", "file"}), 3,
                 "not every pose and feature has a value to start from; --start composed and zero need none");
  const auto store_of = [&](const std::string& map) {
    EXPECT_EQ(call({"build", map, "-o", map + ".maps"}).exit_code, 0);
    return map + ".maps";
  };
  EXPECT_NEAR(report_of({"join", store_of(first), store_of(second)})["chi2"], chi2, 1e-6 * chi2);
}

TEST_F(SeveralInputs, AFolderHasATrajectoryOfEachSession) {
  const auto out = folder.path() / "out";
  ASSERT_EQ(call({"run", a, b, "-o", out.string(), "--no-verdict"}).exit_code, 0);
  for (const char* name : {"trajectory_0.tum", "trajectory_1.tum"}) {
    const std::string text = content_of(out / name);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 501) << "with its header";
  }
}

TEST_F(SeveralInputs, ATrajectoryOfOneFileSaysThatItMixesSessions) {
  const std::string two = (folder.path() / "two.tum").string();
  const Ended ended = call({"run", a, b, "-o", two, "--no-verdict"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, HasSubstr("two.tum: has the poses of several sessions one after the other"));
  EXPECT_EQ(call({"run", a, "-o", two, "--no-verdict"}).err, "");
}

TEST_F(SeveralInputs, PartsAreTakenOneByOneWhereAskedFor) {
  EXPECT_EQ(report_of({"run", a, b, "--features", "own", "--parts", "largest"})["poses"], 500);
  const auto out = folder.path() / "parts";
  const Ended all = call({"run", a, b, "--features", "own", "--parts", "all", "-o", out.string()});
  ASSERT_EQ(all.exit_code, 0);
  for (const std::string part : {"1", "2"}) {
    EXPECT_TRUE(std::filesystem::exists(out / ("part_" + part) / "map.g2o"));
    EXPECT_THAT(all.out, HasSubstr(b + ", part " + part + ": 2D, 500 poses"));
  }
  EXPECT_EQ(call({"run", a, b, "--parts", "all"}).exit_code, 2);
  for (const std::string command : {"solve", "compare"}) {
    expect_failure(call({command, a, b, "--parts", "all"}), 2,
                   "--parts is \"all\", which makes a map of each part: it goes with `mapjoin run -o DIR`");
    expect_failure(call({command, a, b, "--parts", "some"}), 2, "--parts is \"some\", not refuse or largest");
  }
}

TEST_F(SeveralInputs, APartWithoutAMapDoesNotKeepTheOthersFromTheirs) {
  const std::string log =
      folder.file("log.g2o", kSmallLog + "EDGE_SE2 20 21 1 0 0 0 0 0 0 0 0\nEDGE_SE2 30 31 1 0 0 1 0 0 1 0 1\n").string();
  const auto out = folder.path() / "parts";
  const Ended ended = call({"run", log, "--parts", "all", "-o", out.string()});
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.err, HasSubstr("log.g2o, part 2: "));
  EXPECT_TRUE(std::filesystem::exists(out / "part_1" / "map.g2o") && std::filesystem::exists(out / "part_3" / "map.g2o"));
  EXPECT_FALSE(std::filesystem::exists(out / "part_2"));
}

TEST_F(SeveralInputs, RunsSayWhereEarlierOnesAreLeftInTheirFolder) {
  const std::string two = kSmallLog + "EDGE_SE2 20 21 1 0 0 1 0 0 1 0 1\n";
  const std::string out = (folder.path() / "out").string();
  const auto run_all = [&](const std::string& text) {
    return call({"run", folder.file("log.g2o", text).string(), "--parts", "all", "-o", out});
  };
  const std::string left = ": holds the map of an earlier run, not of this one; remove it";
  EXPECT_THAT(run_all(two + "EDGE_SE2 30 31 1 0 0 1 0 0 1 0 1\n").err, Not(HasSubstr(left)));
  const Ended fewer = run_all(two);
  EXPECT_EQ(fewer.exit_code, 0);
  EXPECT_EQ(count_of(fewer.err, left), 1U) << fewer.err;
  EXPECT_THAT(fewer.err, HasSubstr(out + "/part_3" + left));
  const Ended whole = call({"run", folder.file("whole.g2o", kSmallLog).string(), "-o", out});
  EXPECT_EQ(count_of(whole.err, left), 3U) << whole.err;
  EXPECT_THAT(run_all(two).err, HasSubstr(out + left));
}

TEST_F(SeveralInputs, OneWrongIdIsNamedNotTakenForFeaturesThatLieDifferently) {
  std::string text = content_of(a);
  const std::string right = "EDGE_SE2_XY 399 1087 ";
  ASSERT_EQ(count_of(text, right), 1U);
  text.replace(text.find(right), right.size(), "EDGE_SE2_XY 399 1077 ");
  const Ended ended = call({"run", folder.file("wrong.g2o", text).string(), b});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("MISFIT: observation of feature 1077 from pose 399 "));
}

TEST_F(SeveralInputs, AStoreOfSeveralAsksForSuchFeaturesToo) {
  const std::string other = (folder.path() / "other.g2o").string();
  ASSERT_EQ(call({"simulate", "--poses", "500", "--seed", "9", "-o", other}).exit_code, 0);
  const std::string store = (folder.path() / "both.maps").string();
  ASSERT_EQ(call({"build", a, other, "-o", store}).exit_code, 0);
  const Ended asked = call({"join", store});
  EXPECT_EQ(asked.exit_code, 3);
  EXPECT_THAT(asked.err, HasSubstr("`mapjoin build` with --features own where ids mean other features in each input"));
  EXPECT_EQ(call({"join", store, "--features", "shared"}).exit_code, 0);
  const std::string said = (folder.path() / "said.maps").string();
  ASSERT_EQ(call({"build", a, other, "--features", "shared", "-o", said}).exit_code, 0);
  EXPECT_EQ(call({"join", said}).exit_code, 0) << "which says that they are shared";
}

/// Edges of a metre from each of these poses to the next one.
std::string steps_from(const std::vector<int>& poses) {
  std::string text;
  for (const int from : poses) text += fmt::format("EDGE_SE2 {} {} 1 0 0 1 0 0 1 0 1\n", from, from + 1);
  return text;
}

TEST_F(SeveralInputs, ATruthThatCountsPosesCountsThoseOfTheWholeLog) {
  std::string lines;
  for (const int k : {0, 1, 2, 3, 4}) lines += fmt::format("{} {} 0 0 0 0 0 1\n", k, k);
  const std::string truth = folder.file("truth.tum", lines).string();
  const std::string log = folder.file("log.g2o", steps_from({0, 5, 6})).string();
  const auto largest = report_of({"run", log, "--truth", truth, "--parts", "largest"})["errors"]["ate"]["translation"];
  EXPECT_EQ(largest["count"], 3);
  const auto out = folder.path() / "out";
  ASSERT_EQ(call({"run", log, "--truth", truth, "--parts", "all", "-o", out.string()}).exit_code, 0);
  const auto errors_in = [&](const std::string& part) {
    return nlohmann::json::parse(content_of(out / part / "report.json"))["errors"]["ate"]["translation"];
  };
  EXPECT_EQ(errors_in("part_1"), largest);
  EXPECT_EQ(errors_in("part_2")["count"], 2);
  const auto compared = report_of({"compare", log, "--truth", truth, "--parts", "largest", "--poses-per-map", "2"});
  EXPECT_NEAR(compared["cases"][0]["polished"]["from_truth"]["ate"]["translation"]["rms"], 0.0, 1e-9);
}

TEST_F(SeveralInputs, APartThatTheTruthDoesNotKnowIsMappedAllTheSame) {
  const std::string log = folder.file("log.g2o", steps_from({0, 5, 6})).string();
  const std::string truth = folder.file("truth.g2o", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n").string();
  const auto out = folder.path() / "out";
  const Ended ended = call({"run", log, "--truth", truth, "--parts", "all", "-o", out.string(), "--quiet"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_EQ(ended.err, "mapjoin: " + truth + ": has no pose or feature of the part in " + (out / "part_1").string() +
                           ", by name, time or count; its map is not measured against it, and `mapjoin error` measures it "
                           "against another\n");
  const auto errors_in = [&](const std::string& part) {
    return nlohmann::json::parse(content_of(out / part / "report.json"))["errors"];
  };
  EXPECT_TRUE(errors_in("part_1").is_null());
  EXPECT_EQ(errors_in("part_2")["ate"]["translation"]["count"], 2);
  const std::string none = folder.file("none.g2o", "VERTEX_SE2 9 0 0 0\n").string();
  const Ended refused = call({"run", log, "--truth", none, "--parts", "all", "-o", (folder.path() / "no").string()});
  EXPECT_EQ(refused.exit_code, 2) << "where it knows no part";
  EXPECT_THAT(refused.err, HasSubstr(none + ": has no pose or feature of " + log));
}

TEST_F(SeveralInputs, FeaturesOfTheirOwnLeaveThemApart) {
  const Ended apart = call({"run", a, b, "--features", "own"});
  EXPECT_EQ(apart.exit_code, 3);
  EXPECT_THAT(apart.err, HasSubstr("nothing ties its 2 parts together"));
  EXPECT_THAT(apart.err, HasSubstr("--associate ties them by features that they share"));
}

TEST_F(SeveralInputs, StoresThatNothingTiesAreRefusedWithWhatTiesStores) {
  std::vector<std::string> join = {"join"};
  for (const std::string feature : {"7", "8"}) {
    const std::string see = "EDGE_SE2_XY 0 " + feature + " 2 1 1 0 1\n";
    const std::string log = folder.file(feature + ".g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n" + see).string();
    join.push_back((folder.path() / (feature + ".maps")).string());
    ASSERT_EQ(call({"build", log, "-o", join.back()}).exit_code, 0);
  }
  const Ended apart = call(join);
  expect_failure(apart, 3, join[1] + " + " + join[2] + ": nothing ties its 2 parts together; they hold pose 0, pose 0 of ");
  EXPECT_THAT(apart.err, ::testing::EndsWith("; --features own --associate ties stores by features that they share\n"));
}

TEST_F(SeveralInputs, FeaturesOfTheirOwnAreFoundToBeTheSame) {
  const auto joined = report_of({"run", a, b, "--features", "own", "--associate"});
  EXPECT_EQ(joined["poses"], 1000);
  const std::size_t features = report_of({"run", a, b})["features"];
  EXPECT_GE(joined["features"], features);
  EXPECT_LE(joined["features"], features + 3) << "hardly any stays apart";
  EXPECT_EQ(joined["verdict"], "fits");
  EXPECT_EQ(report_of({"run", a, b, "--associate"})["verdict"], "fits");
}

TEST_F(SeveralInputs, OtherWorldsStayApartWhichIsExplained) {
  const std::string other = (folder.path() / "other.g2o").string();
  ASSERT_EQ(call({"simulate", "--poses", "300", "--seed", "9", "-o", other}).exit_code, 0);
  const Ended apart = call({"run", a, other, "--associate", "--features", "own"});
  EXPECT_EQ(apart.exit_code, 3);
  EXPECT_THAT(apart.err, HasSubstr("pose 0 and pose 0 of session 1 stay apart"));
  EXPECT_THAT(apart.err, HasSubstr("--parts largest takes the largest part"));
  EXPECT_EQ(report_of({"run", a, other, "--associate", "--features", "own", "--parts", "largest"})["poses"], 500);
  EXPECT_EQ(call({"run", a, other, "--associate", "--parts", "all", "-o", (folder.path() / "parts").string()}).exit_code, 2);
}

struct Robots {
  int count;
  double chi2;
};
void PrintTo(const Robots& robots, std::ostream* out) {
  *out << robots.count;
}
class RobotsData : public ::testing::TestWithParam<Robots> {};

TEST_P(RobotsData, ReachTheOptimumOfTheirFullGraph) {
  std::vector<std::string> arguments = {"run"};
  for (int k = 0; k < GetParam().count; ++k) {
    const auto robots = "robots/blocks_world_" + std::to_string(GetParam().count) + "robots/";
    arguments.push_back(data_file(robots + std::to_string(k) + ".g2o").string());
  }
  EXPECT_NEAR(report_of(arguments)["chi2"], GetParam().chi2, 1e-6 * GetParam().chi2);
}
INSTANTIATE_TEST_SUITE_P(OfManyRobots, RobotsData,
                         ::testing::Values(Robots{4, 5.5508915}, Robots{16, 16.68012}, Robots{25, 30.471484}));

}  // namespace
}  // namespace mapjoin::testing
