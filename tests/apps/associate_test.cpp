// SPDX-License-Identifier: BSD-3-Clause
// The option --associate: what it writes and says, and what it does not go with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <mapjoin/io/formats/log_format.hpp>
#include <sstream>
#include <tests/apps/command.hpp>
#include <tests/support/cut_log.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/temporary_folder.hpp>
#include <tests/support/wood.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class AssociateCommandTest : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder.path() / name).string(); }
  TemporaryFolder folder;
  const std::string log = kBundledLog;
};

struct Explained {
  double distance = 0.0;
  double gate = 0.0;
  std::size_t alternatives = 0;
};

/// The lines of an associations.csv for sightings of features that were seen before.
std::vector<Explained> explained(const std::string& csv) {
  std::vector<Explained> found;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> fields = fields_of(line);
    if (found.empty() && fields.at(3) == "distance") continue;
    if (!fields.at(3).empty()) found.push_back({std::stod(fields[3]), std::stod(fields.at(4)), std::stoul(fields.at(5))});
  }
  return found;
}

TEST_F(AssociateCommandTest, FindsTheFeaturesOfTheBundledLogAndExplainsEachSighting) {
  const auto report = report_of({"run", log, "--associate", "-o", file("result")});
  EXPECT_EQ(report["association"]["method"], "jcbb");
  EXPECT_EQ(report["association"]["sightings"], 2524);
  EXPECT_EQ(report["association"]["features"], 145);
  EXPECT_EQ(report["verdict"], "fits");
  const std::string lines = content_of(folder.path() / "result" / "associations.csv");
  EXPECT_THAT(lines, StartsWith("base,feature,joined,distance,gate,alternatives,base_session\n"));
  EXPECT_EQ(std::ranges::count(lines, '\n'), 2525);
  const std::vector<Explained> found = explained(lines);
  ASSERT_FALSE(found.empty());
  for (const auto& [distance, gate, alternatives] : found) {
    EXPECT_GT(distance, 0.0);
    EXPECT_LE(distance, gate);
    EXPECT_LT(alternatives, 164U);
  }
}

TEST_F(AssociateCommandTest, WithRobustIsNotMisledByAWrongClosure) {
  std::ofstream(file("wrong.g2o")) << content_of(log) << "EDGE_SE2 480 560 0.1 0.1 0.1 1111 0 0 1111 0 1111\n";
  const auto report = report_of({"run", file("wrong.g2o"), "--associate", "--robust", "-o", file("right.g2o")});
  EXPECT_EQ(report["association"]["features"], 145);
  EXPECT_EQ(report["robust"]["closures"], 1);
  EXPECT_EQ(report["verdict"], "fits");
}

TEST_F(AssociateCommandTest, ComparesNoFeaturesWithThoseOfATruth) {
  ASSERT_EQ(call({"simulate", "--poses", "60", "--quiet", "-o", file("log.g2o"), "--truth", file("truth.g2o")}).exit_code, 0);
  const std::string said = "--associate named the features of the map, or of the truth: only poses are compared with it\n";
  const Ended named = call({"run", file("log.g2o"), "--truth", file("truth.g2o"), "-o", file("named")});
  EXPECT_THAT(named.out, AllOf(HasSubstr("NEES         features"), Not(HasSubstr(said))));
  const Ended run = call({"run", file("log.g2o"), "--associate", "--truth", file("truth.g2o"), "-o", file("result")});
  EXPECT_THAT(run.out, AllOf(HasSubstr("NEES         poses"), Not(HasSubstr("NEES         features")), HasSubstr(said)));
  ASSERT_EQ(call({"build", file("log.g2o"), "--associate", "--quiet", "-o", file("log.maps")}).exit_code, 0);
  EXPECT_THAT(call({"join", file("log.maps"), "--truth", file("truth.g2o")}).out,
              AllOf(Not(HasSubstr("NEES         features")), HasSubstr(said)));
  ASSERT_EQ(call({"run", file("log.g2o"), "--associate", "--quiet", "-o", file("map.g2o")}).exit_code, 0);
  for (const std::string map : {"result", "result/map.g2o", "map.g2o"}) {
    const Ended error = call({"error", file(map), file("truth.g2o")});
    EXPECT_THAT(error.out, AllOf(HasSubstr("ATE          60 of 60 poses"), Not(HasSubstr("\nfeatures")), HasSubstr(said)));
    EXPECT_THAT(call({"plot", file(map), "--truth", file("truth.g2o"), "--quiet", "-o", file("plot.svg")}).err,
                HasSubstr("truth.g2o: its features are not drawn: --associate named them"));
  }
}

TEST_F(AssociateCommandTest, WritesTheSameWithAnyNumberOfJobs) {
  for (const std::string jobs : {"1", "2"}) {
    ASSERT_EQ(call({"run", log, "--associate", "--jobs", jobs, "--quiet", "-o", file(jobs + ".g2o")}).exit_code, 0);
  }
  EXPECT_EQ(content_of(file("1.associations.csv")), content_of(file("2.associations.csv")));
  EXPECT_EQ(content_of(file("1.g2o")), content_of(file("2.g2o")));
}

/// The feature that is as far from the last index as `feature` is from the first.
FeatureIndex opposite(const Log<2>& log, FeatureIndex feature) {
  return FeatureIndex(log.features.size() - 1 - feature.position());
}

TEST_F(AssociateCommandTest, TiesStoresOfUnknownFrames) {
  const auto world = wood<2>(1).log;
  for (const std::size_t session : {0U, 1U}) {
    const std::string name = std::to_string(session);
    auto log_of_session = cut_session(world, session, 2);
    // Ids in an order of their own.
    for (auto& feature : log_of_session.graph.feature_factors) feature.target = opposite(log_of_session, feature.target);
    std::ranges::reverse(log_of_session.initial.features);
    ASSERT_TRUE(write_log<2>(log_of_session, LogFormat::kG2o, file(name + ".g2o")));
    ASSERT_EQ(call({"build", file(name + ".g2o"), "--poses-per-map", "15", "--quiet", "-o", file(name + ".maps")}).exit_code,
              0);
  }
  const auto of_logs = report_of({"run", file("0.g2o"), file("1.g2o"), "--poses-per-map", "15", "--features", "own",
                                  "--associate", "-o", file("logs.g2o")});
  const auto of_stores =
      report_of({"join", file("0.maps"), file("1.maps"), "--features", "own", "--associate", "-o", file("stores.g2o")});
  EXPECT_GT(of_logs["local_maps"]["count"].get<int>(), 2);
  EXPECT_EQ(of_stores["association"], of_logs["association"]);
  EXPECT_EQ(content_of(file("stores.associations.csv")), content_of(file("logs.associations.csv")));
  EXPECT_EQ(of_stores["local_maps"]["count"], of_logs["local_maps"]["count"]);
  EXPECT_NEAR(of_stores["chi2"].get<double>(), of_logs["chi2"].get<double>(), 1e-9 * of_logs["chi2"].get<double>());
  EXPECT_EQ(of_stores["verdict"], "fits");
}

TEST_F(AssociateCommandTest, NamesFeaturesOfSeveralFilesApartAndWhatIsRejectedAsTheMapDoes) {
  const auto world = wood<2>(1).log;
  auto first = cut_session(world, 0, 2);
  auto second = cut_session(world, 1, 2);
  auto& wrong = second.graph.feature_factors[second.graph.feature_factors.size() / 2];
  wrong.measured.x() += 3.0;
  ASSERT_TRUE(write_log<2>(first, LogFormat::kG2o, file("0.g2o")));
  ASSERT_TRUE(write_log<2>(second, LogFormat::kG2o, file("1.g2o")));
  ASSERT_EQ(call({"run", file("0.g2o"), file("1.g2o"), "--features", "own", "--associate", "--robust", "--quiet", "-o",
                  file("result")})
                .exit_code,
            0);
  const std::vector<std::string> rejected = lines_of(content_of(folder.path() / "result" / "rejected.csv"));
  ASSERT_EQ(rejected.size(), 2U);
  const std::string from = std::to_string(second.poses[wrong.base].key);
  ASSERT_THAT(rejected[1], StartsWith("observation," + from + ","));
  const std::string to = fields_of(rejected[1]).at(2);
  // Ids of the files are above 1000, where the poses end, and below 10000.
  const std::string id = std::to_string(11000 + second.features[wrong.target].key);
  EXPECT_THAT(content_of(folder.path() / "result" / "associations.csv"), HasSubstr("\n" + from + "," + id + "," + to + ","));
}

TEST_F(AssociateCommandTest, GoesWithBuildNotWithTheJoinOfAStore) {
  ASSERT_EQ(call({"build", log, "--associate", "--quiet", "-o", file("log.maps")}).exit_code, 0);
  EXPECT_THAT(content_of(file("log.associations.csv")), StartsWith("base,"));
  EXPECT_EQ(report_of({"join", file("log.maps")})["features"], 145);
  const Ended refused = call({"join", file("log.maps"), "--associate"});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_THAT(refused.err, HasSubstr("--associate goes with `mapjoin build`"));
}

TEST_F(AssociateCommandTest, TheRecordBesideAStoreIsNotLeftOverWhenThatIsJoined) {
  const std::string small = folder.file("small.g2o", kSmallLog).string();
  ASSERT_EQ(call({"build", small, "--associate", "--quiet", "-o", file("town.maps")}).exit_code, 0);
  EXPECT_EQ(call({"join", file("town.maps"), "--quiet", "-o", file("town.g2o")}).err, "");
  EXPECT_THAT(call({"solve", small, "--quiet", "-o", file("town.g2o")}).err, HasSubstr("associations.csv: was there before"));
}

TEST_F(AssociateCommandTest, SaysThatPartsWithoutFeaturesStayApart) {
  const std::string edge = " 1 0 0 1 0 0 1 0 1\n";
  const auto parts = folder.file("parts.g2o", "EDGE_SE2 0 1" + edge + "EDGE_SE2 1 2" + edge + "EDGE_SE2 5 6" + edge).string();
  for (const std::string command : {"run", "build"}) {
    const Ended ended = call({command, parts, "--associate", "-o", file(command)});
    EXPECT_EQ(ended.exit_code, 3);
    EXPECT_THAT(ended.err, HasSubstr("pose 0 and pose 5 stay apart"));
  }
}

TEST_F(AssociateCommandTest, TellsOfTheLargestPartWhereThatIsTaken) {
  const std::string other = folder.file("other.g2o", kSmallLog).string();
  const auto report = report_of({"run", log, other, "--associate", "--parts", "largest", "-o", file("result")});
  EXPECT_EQ(report["poses"], 1000);
  EXPECT_EQ(report["association"]["sightings"], report["observations"]);
  EXPECT_EQ(report["association"]["features"], report["features"]);
  const std::string lines = content_of(folder.path() / "result" / "associations.csv");
  EXPECT_EQ(std::ranges::count(lines, '\n'), 1 + report["observations"].get<int>());
}

TEST_F(AssociateCommandTest, SaysThatThereIsNothingToAssociate) {
  const auto edges = folder.file("edges.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n").string();
  const Ended ended = call({"run", edges, "--associate"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("associated   nothing: there are no features\n"));
}

TEST_F(AssociateCommandTest, RefusesWhatMeansNothing) {
  EXPECT_THAT(call({"run", log, "--association", "nn"}).err, HasSubstr("--association is of --associate"));
  EXPECT_THAT(call({"run", log, "--confidence", "0.9"}).err, HasSubstr("--confidence is of --associate and --robust"));
  EXPECT_THAT(call({"run", log, "--associate", "--confidence", "1"}).err, HasSubstr("between 0 and 1"));
  EXPECT_THAT(call({"run", log, "--associate", "--follow"}).err, HasSubstr("which --associate ignores"));
}

}  // namespace
}  // namespace mapjoin::testing
