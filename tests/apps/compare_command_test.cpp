// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <chrono>
#include <regex>
#include <sstream>
#include <tests/apps/command.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// One comparison in 2D, with the truth, which all tests look at.
class Compare : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    ended_ = call(
        {"compare", kBundledLog, "--poses-per-map", "20,60", "--truth", kBundledTruth, "-o", out().string(), "--jobs", "1"});
  }
  static void TearDownTestSuite() { delete folder_; }
  static fs::path out() { return folder_->path() / "out"; }
  static std::string content(const std::string& name) { return content_of(out() / name); }

  static TemporaryFolder* folder_;
  static Ended ended_;
};
TemporaryFolder* Compare::folder_ = nullptr;
Ended Compare::ended_;

TEST_F(Compare, FillsItsFolderAndTellsTheTable) {
  EXPECT_EQ(ended_.exit_code, 0) << ended_.err;
  EXPECT_EQ(ended_.err, "");
  for (const std::string name : {"compare.json", "compare.csv", "compare.html"}) EXPECT_TRUE(fs::exists(out() / name)) << name;
  EXPECT_THAT(ended_.out, HasSubstr("best         chi2 4702.179445, dof 4762"));
  EXPECT_THAT(ended_.out, HasSubstr("full SLAM      1  absolute  aligned"));
  EXPECT_THAT(ended_.out, HasSubstr("full SLAM      1  absolute  tree"));
  EXPECT_THAT(ended_.out, HasSubstr("joining       60  relative  gradual batch"));
  EXPECT_THAT(ended_.out, HasSubstr("How far it is from the truth"));
}

TEST_F(Compare, ReportsEveryCase) {
  const json report = json::parse(content("compare.json"));
  EXPECT_EQ(report.at("command"), "compare");
  EXPECT_EQ(report.at("poses"), 1000);
  ASSERT_EQ(report.at("cases").size(), 7U + 2U * 9U);
  const json& best = report.at("cases").at(report.at("best").get<std::size_t>());
  EXPECT_EQ(best.at("polished").at("from_best").at("poses").at("translation").at("max"), 0.0);
  for (const json& one : report.at("cases")) {
    SCOPED_TRACE(one.dump());
    EXPECT_EQ(one.at("result"), "best");
    EXPECT_NEAR(one.at("polished").at("chi2"), 4702.179445, 1e-5);
    EXPECT_EQ(one.at("joined").at("from_best").at("relative_poses").size(), report.at("spans").size());
    EXPECT_GT(one.at("polished").at("from_truth").at("ate").at("translation").at("rms"), 0.01);
    EXPECT_GT(one.at("effort").at("seconds"), 0.0);
    EXPECT_GT(one.at("system_bytes"), 0);
  }
  EXPECT_EQ(report.at("other_weights").at("covariance"), "identity");
  EXPECT_EQ(report.at("other_weights").at("converged"), true);
}

TEST_F(Compare, AgreesWithARunOfEachCommand) {
  const json report = json::parse(content("compare.json"));
  const json run = report_of({"run", kBundledLog, "--poses-per-map", "20", "--schedule", "sequential", "--state", "relative"});
  const auto same = [](const json& one) {
    return one.at("steps_per_map") == 20 && one.at("state") == "relative" && one.at("schedule") == "sequential";
  };
  const json& cases = report.at("cases");
  const auto found = std::find_if(cases.begin(), cases.end(), same);
  ASSERT_NE(found, cases.end());
  EXPECT_EQ(found->at("join").at("chi2"), run.at("join").at("chi2"));
  EXPECT_EQ(found->at("join").at("iterations"), run.at("join").at("iterations"));
  EXPECT_EQ(found->at("joined").at("chi2"), run.at("recover").at("chi2"));
  EXPECT_EQ(found->at("polished").at("chi2"), run.at("chi2"));
  EXPECT_EQ(found->at("polish_iterations"), run.at("polish").at("iterations"));
  const json identity = report_of({"run", kBundledLog, "--covariance", "identity"});
  EXPECT_EQ(report.at("other_weights").at("chi2"), identity.at("chi2"));
}

TEST_F(Compare, WritesARowPerCaseAsCsv) {
  const auto rows = lines_of(content("compare.csv"));
  ASSERT_EQ(rows.size(), 1U + 7U + 2U * 9U);
  const auto keys = fields_of(rows.front());
  for (const std::string& row : rows) EXPECT_EQ(fields_of(row).size(), keys.size()) << row;
  for (const std::string key : {"formulation", "joined_chi2", "memory_mb", "joined_poses_max_m", "joined_relative_100_m",
                                "polished_ate_m", "polished_rpe_1_m", "result"}) {
    EXPECT_EQ(std::count(keys.begin(), keys.end(), key), 1) << key;
  }
}

TEST_F(Compare, WritesAPageThatIsWellFormedAndNeedsNothingElse) {
  const std::string page = content("compare.html");
  std::istringstream stream(page);
  boost::property_tree::ptree tree;
  ASSERT_NO_THROW(boost::property_tree::read_xml(stream, tree));
  EXPECT_EQ(tree.get<std::string>("html.head.title"), "Joining beside full SLAM: manhattan2d.g2o");
  EXPECT_EQ(tree.get_child("html.body").count("figure"), 2U);
  std::string rest = std::regex_replace(page, std::regex(R"(xmlns="http://www\.w3\.org/2000/svg")"), "");
  for (const std::string fetched : {"http", "src=", "href=", "url(", "@import"}) EXPECT_THAT(rest, Not(HasSubstr(fetched)));
  EXPECT_THAT(page, HasSubstr("25 of the 25 ways reach it"));
}

/// A report without times and memory.
json without_effort(json report) {
  for (json& one : report.at("cases")) one.erase("effort");
  return report;
}

/// CSV without the columns of time and memory.
std::string without_effort(const std::string& csv) {
  const auto rows = lines_of(csv);
  const auto keys = fields_of(rows.front());
  std::string rest;
  for (const std::string& row : rows) {
    const auto fields = fields_of(row);
    for (std::size_t c = 0; c < keys.size(); ++c) {
      if (keys[c] != "seconds" && keys[c] != "cpu_seconds" && keys[c] != "memory_mb") rest += fields[c] + ",";
    }
    rest += "\n";
  }
  return rest;
}

TEST_F(Compare, IsTheSameForAnyNumberOfThreads) {
  const fs::path two = folder_->path() / "two";
  ASSERT_EQ(
      call({"compare", kBundledLog, "--poses-per-map", "20,60", "--truth", kBundledTruth, "-o", two.string(), "--jobs", "2"})
          .exit_code,
      0);
  EXPECT_EQ(without_effort(json::parse(content("compare.json"))),
            without_effort(json::parse(content_of(two / "compare.json"))));
  EXPECT_EQ(without_effort(content("compare.csv")), without_effort(content_of(two / "compare.csv")));
  const auto pictures = [](const std::string& page) { return page.substr(page.find("<h2>The maps</h2>")); };
  EXPECT_EQ(pictures(content("compare.html")), pictures(content_of(two / "compare.html")));
}

TEST_F(Compare, TakesSpaceAndIdentityCovariancesToo) {
  const json report =
      report_of({"compare", (kBundledData / "manhattan3d.g2o").string(), "--poses-per-map", "40", "--covariance", "identity"});
  EXPECT_EQ(report.at("dimension"), 3);
  EXPECT_EQ(report.at("convention").at("covariance"), "identity");
  EXPECT_EQ(report.at("other_weights").at("covariance"), "original");
  EXPECT_TRUE(report.at("cases").at(0).at("polished").at("from_truth").is_null());
}

TEST_F(Compare, AnIntrudingNameIsTextOnThePage) {
  const auto log = folder_->file("a<b&c.g2o", content_of(kBundledLog));
  const fs::path there = folder_->path() / "named";
  ASSERT_EQ(call({"compare", log.string(), "--poses-per-map", "50", "-o", there.string(), "--quiet"}).exit_code, 0);
  EXPECT_THAT(content_of(there / "compare.html"), HasSubstr("<h1>Joining beside full SLAM: a&lt;b&amp;c.g2o</h1>"));
}

TEST_F(Compare, SaysWhichLengthsCutTheLogIntoNoLocalMap) {
  std::string text;  // an edge over every pose, so that no length has poses of its own
  for (int pose = 0; pose < 5; ++pose) {
    text += fmt::format("EDGE_SE2 {} {} 1 0 0 1 0 0 1 0 1\n", pose, pose + 1);
    if (pose < 4) text += fmt::format("EDGE_SE2 {} {} 2 0 0 1 0 0 1 0 1\n", pose, pose + 2);
  }
  const fs::path there = folder_->path() / "uncut";
  const Ended uncut =
      call({"compare", folder_->file("uncut.g2o", text).string(), "--poses-per-map", "2", "-o", there.string()});
  EXPECT_EQ(uncut.exit_code, 0) << uncut.err;
  const std::string note = "maps of 2: this cuts the log into no local map, so that joining is full SLAM once more; another";
  EXPECT_EQ(count_of(uncut.out, "note         " + note), 1U) << uncut.out;
  EXPECT_THAT(content_of(there / "compare.html"), HasSubstr("<dt>Note</dt><dd>" + note));
  const Ended cut = call({"compare", folder_->file("cut.g2o", kSmallLog).string(), "--poses-per-map", "2"});
  EXPECT_THAT(cut.out, Not(HasSubstr("no local map")));
}

TEST_F(Compare, RefusesListsThatAreNone) {
  for (const std::string list : {"", "1", "5,", "5,,7", "-3", "5;7", "a", "1.5", "2000000"}) {
    const Ended ended = call({"compare", kBundledLog, "--poses-per-map", list});
    EXPECT_EQ(ended.exit_code, 2) << list;
    EXPECT_THAT(ended.err, HasSubstr("not whole numbers from 2 to 1000000 with commas between them"));
  }
}

TEST_F(Compare, RefusesATruthOfSomethingElse) {
  const auto truth = folder_->file("other.tum", "999 0 0 0 0 0 0 1\n5001 1 0 0 0 0 0 1\n");
  const Ended ended = call({"compare", kBundledLog, "--truth", truth.string()});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, HasSubstr("the truth has fewer than two poses of the log"));
}

TEST_F(Compare, ShowsHowFarTheJoinIsThatTellsWhetherFeaturesAreShared) {
  if (std::system("command -v script > /dev/null") != 0) GTEST_SKIP() << "needs script, which gives a command a terminal";
  const std::string log = kSmallLog + "EDGE_SE2_XY 0 8 1 -1 1 0 1\nEDGE_SE2_XY 2 8 -1 -1 1 0 1\n";
  const std::string a = folder_->file("a.g2o", log).string();
  const std::string b = folder_->file("b.g2o", log).string();
  Process process({"script", "-qec", kCommand + " compare " + a + " " + b + " --keep-copies --poses-per-map 2", "/dev/null"},
                  {});
  EXPECT_EQ(process.wait(), 0) << process.standard_output();
  EXPECT_THAT(process.standard_output(), HasSubstr("\rcovariances")) << "of its verdict, which no case has";
}

TEST_F(Compare, LeavesNothingBehindWhereTheInputIsBad) {
  const auto log = folder_->file("bad.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\n");
  const fs::path there = folder_->path() / "nothing";
  const Ended ended = call({"compare", log.string(), "-o", there.string()});
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.err, StartsWith("mapjoin: no case gives a map; the first: "));
  EXPECT_FALSE(fs::exists(there));
}

TEST_F(Compare, EndsWhenItIsInterrupted) {
  const fs::path there = folder_->path() / "interrupted";
  Process process(command_line({"compare", kBundledLog, "--poses-per-map", "2,3,4", "-o", there.string()}));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  ASSERT_TRUE(process.is_running());
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 130);
  EXPECT_EQ(process.standard_error(), "mapjoin: interrupted\n");
  EXPECT_FALSE(fs::exists(there));
}

}  // namespace
}  // namespace mapjoin::testing
