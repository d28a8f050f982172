// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <tests/mpi/ranks_test.hpp>
#include <tests/support/data.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

constexpr int kRanks[] = {1, 2, 4};

class RunOnRanks : public RanksTest {
 protected:
  /// Expects any number of ranks to find the optimum of one process.
  static void expect_the_same_optimum(const std::string& log) {
    const auto one = report_of({"run", log, "--no-verdict"});
    for (const int ranks : kRanks) {
      const auto several = report_of_ranks(ranks, {"run", log});
      const double chi2 = one["chi2"];
      EXPECT_NEAR(several["chi2"], chi2, 1e-9 * chi2) << log << " on " << ranks;
      EXPECT_EQ(several["dof"], one["dof"]) << log << " on " << ranks;
    }
  }
  std::string converted(const std::string& file) const {
    const std::string log = path(std::filesystem::path(file).stem().stem().string() + ".g2o");
    EXPECT_EQ(call({"convert", data_file(file).string(), log}).exit_code, 0);
    return log;
  }
  /// A copy of the bundled log whose line `number` is `line` instead.
  std::string with_line(std::size_t number, const std::string& line) const {
    std::istringstream lines(content_of(bundled("manhattan2d.g2o")));
    std::ofstream file(path("changed.g2o"));
    std::size_t count = 0;
    for (std::string old; std::getline(lines, old);) file << (++count == number ? line : old) << '\n';
    return path("changed.g2o");
  }
};

TEST_F(RunOnRanks, FindsTheOptimumOfOneProcessInThePlane) {
  expect_the_same_optimum(bundled("manhattan2d.g2o"));
}

TEST_F(RunOnRanks, FindsTheOptimumOfOneProcessInSpace) {
  expect_the_same_optimum(bundled("manhattan3d.g2o"));
}

TEST_F(RunOnRanks, FindsTheOptimumOfOneProcessOnRealLogs) {
  for (const char* file : {"vicpark-6898/vicpark6898.g2o.gz", "dlr/dlr_corrected.g2o.gz", "pose-graphs-2d/intel.g2o.gz",
                           "pose-graphs-3d/sphere2500.g2o.gz"}) {
    expect_the_same_optimum(converted(file));
  }
}

TEST_F(RunOnRanks, FindsTheSameOptimumWithSeveralRegionsOneAfterTheOther) {
  for (const char* log : {"manhattan2d.g2o", "manhattan3d.g2o"}) {
    const auto one = report_of({"run", bundled(log), "--no-verdict"});
    for (const int ranks : kRanks) {
      for (const char* regions : {"2", "5"}) {
        const auto several = report_of_ranks(ranks, {"run", bundled(log), "--regions", regions});
        EXPECT_NEAR(several["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>()) << log << ' ' << ranks << ' ' << regions;
        EXPECT_EQ(several["dof"], one["dof"]) << log << ' ' << ranks << ' ' << regions;
      }
    }
  }
}

TEST_F(RunOnRanks, TakesEveryMethodThroughSeveralRegions) {
  const std::string log = bundled("manhattan2d.g2o");
  const auto one = report_of({"run", log, "--no-verdict"});
  for (const char* method : {"gn", "lm", "dogleg"}) {
    const auto several = report_of_ranks(2, {"run", log, "--regions", "3", "--method", method, "--jobs", "2"});
    EXPECT_NEAR(several["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>()) << method;
  }
}

TEST_F(RunOnRanks, WritesTheMapWhoseChi2ItTells) {
  const std::string log = bundled("manhattan2d.g2o");
  const auto told = report_of_ranks(2, {"run", log, "-o", path("map.g2o"), "--regions", "3"});
  const auto map = std::get<Log<2>>(open_log(path("map.g2o")).value());
  const auto read = std::get<Log<2>>(open_log(log).value());
  ASSERT_EQ(map.poses, read.poses);
  ASSERT_EQ(map.features, read.features);
  EXPECT_NEAR(log_chi2(read, map.initial).total(), told["chi2"], 1e-9 * told["chi2"].get<double>());
}

TEST_F(RunOnRanks, HasTheHeadingsOfOneProcess) {
  const std::string log = bundled("manhattan2d.g2o");
  ASSERT_EQ(call({"run", log, "-o", path("one.csv")}).exit_code, 0);
  ASSERT_EQ(call_ranks(2, {"run", log, "-o", path("two.csv")}).exit_code, 0);
  const auto one = std::get<Log<2>>(open_log(path("one.csv")).value()).initial.poses;
  const auto two = std::get<Log<2>>(open_log(path("two.csv")).value()).initial.poses;
  ASSERT_EQ(one.size(), two.size());
  for (const PoseIndex p : indices(one)) EXPECT_NEAR(one[p].rotation.angle(), two[p].rotation.angle(), 1e-4) << p.value;
}

TEST_F(RunOnRanks, CountsWhatTheLogHas) {
  const auto one = report_of({"run", bundled("manhattan3d.g2o"), "--no-verdict"});
  const auto four = report_of_ranks(4, {"run", bundled("manhattan3d.g2o")});
  for (const char* what : {"dimension", "convention", "poses", "features", "odometry", "closures", "observations", "priors",
                           "fixed_poses", "skipped", "gauge"}) {
    EXPECT_EQ(four[what], one[what]) << what;
  }
}

TEST_F(RunOnRanks, CountsSessionsAndWhatIsMeasuredTwice) {
  std::ofstream file(path("log.g2o"));
  std::istringstream lines(content_of(bundled("manhattan2d.g2o")));
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("EDGE_SE2 300 301 ")) continue;
    file << line << '\n';
    if (line.starts_with("EDGE_SE2 ") && ++count % 50 == 0) file << line << '\n';
  }
  file.close();
  const auto one = report_of({"run", path("log.g2o"), "--no-verdict"});
  EXPECT_EQ(one["sessions"], 2);
  EXPECT_EQ(one["repeated_edges"], 19);
  for (const int ranks : kRanks) {
    const auto several = report_of_ranks(ranks, {"run", path("log.g2o")});
    for (const char* what : {"sessions", "odometry", "closures", "repeated_edges"}) EXPECT_EQ(several[what], one[what]) << what;
  }
}

TEST_F(RunOnRanks, SaysWhatEachRankLeftOut) {
  std::ofstream file(path("scans.g2o"));
  std::istringstream lines(content_of(bundled("manhattan2d.g2o")));
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line);) file << line << (++count % 100 == 0 ? "\nROBOTLASER1 0 1 2\n" : "\n");
  file.close();
  const auto report = report_of_ranks(4, {"run", path("scans.g2o")});
  EXPECT_EQ(report["skipped"]["ROBOTLASER1 lines"], count / 100);
}

TEST_F(RunOnRanks, HoldsFixedPosesAndPriorsAsOneProcessDoes) {
  std::ofstream(path("held.g2o")) << content_of(bundled("manhattan2d.g2o")) << "EDGE_PRIOR_SE2 700 3 4 1 9 0 0 9 0 9\n"
                                  << "EDGE_PRIOR_XY 1000 5 5 4 0 4\n";
  const std::string held = path("held.g2o");
  const auto one = report_of({"run", held, "--no-verdict"});
  for (const int ranks : kRanks) {
    for (const char* regions : {"1", "4"}) {
      const auto several = report_of_ranks(ranks, {"run", held, "--regions", regions});
      EXPECT_NEAR(several["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>()) << ranks << ' ' << regions;
      EXPECT_EQ(several["dof"], one["dof"]) << ranks << ' ' << regions;
    }
  }
}

TEST_F(RunOnRanks, WeighsAsItIsAsked) {
  const std::vector<std::string> unweighted{"run", bundled("manhattan2d.g2o"), "--covariance", "identity"};
  const auto one = report_of({"run", bundled("manhattan2d.g2o"), "--covariance", "identity", "--no-verdict"});
  const auto two = report_of_ranks(2, unweighted);
  EXPECT_NEAR(two["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>());
  EXPECT_EQ(two["convention"], one["convention"]);
}

TEST_F(RunOnRanks, FindsTheOptimumWithItsFactorInFiles) {
  const std::string log = bundled("manhattan2d.g2o");
  for (const char* regions : {"1", "6"}) {
    const auto in_memory = report_of_ranks(2, {"run", log, "--regions", regions});
    const auto in_files =
        report_of_ranks(2, {"run", log, "--regions", regions, "--jobs", "2", "--out-of-core", folder.path().string()});
    EXPECT_NEAR(in_files["chi2"], in_memory["chi2"], 1e-9 * in_memory["chi2"].get<double>()) << regions;
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
}

TEST_F(RunOnRanks, SaysWhereALineIsWrongOnceAndEndsAll) {
  for (const std::size_t line : {std::size_t{40}, std::size_t{1700}, std::size_t{3400}}) {
    const Ended ended = call_ranks(4, {"run", with_line(line, "EDGE_SE2 1 2 x"), "-o", path("map.g2o")});
    EXPECT_EQ(ended.exit_code, 3);
    EXPECT_THAT(ended.err, HasSubstr(fmt::format("changed.g2o:{}:14: ", line)));
    EXPECT_EQ(ended.err.find("mapjoin: "), ended.err.rfind("mapjoin: ")) << ended.err;
    EXPECT_FALSE(std::filesystem::exists(path("map.g2o")));
  }
}

TEST_F(RunOnRanks, RefusesAMapThatIsNotFinite) {
  std::ofstream file(path("large.g2o"));
  for (int k = 1; k < 120; ++k) file << "EDGE_SE2 " << k - 1 << ' ' << k << " 1e308 0 0 1 0 0 1 0 1\n";
  file.close();
  for (const int ranks : {1, 2}) {
    const Ended ended = call_ranks(ranks, {"run", path("large.g2o"), "-o", path("map.g2o")});
    EXPECT_EQ(ended.exit_code, 3);
    EXPECT_THAT(ended.err, HasSubstr("large.g2o: its numbers are too large: the map is not finite, or its chi2"));
    EXPECT_EQ(ended.err.find("mapjoin: "), ended.err.rfind("mapjoin: ")) << ended.err;
    EXPECT_FALSE(std::filesystem::exists(path("map.g2o")));
  }
}

TEST_F(RunOnRanks, RefusesALogThatFallsApart) {
  std::ofstream(path("apart.g2o")) << content_of(bundled("manhattan2d.g2o")) << "EDGE_SE2 5000 5001 1 0 0 1 0 0 1 0 1\n";
  const Ended ended = call_ranks(2, {"run", path("apart.g2o")});
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.err, HasSubstr("nothing ties its 2 parts together; they hold pose 0, pose 5000"));
}

TEST_F(RunOnRanks, RefusesWhatIsNotPlainG2o) {
  std::ofstream(path("empty.g2o")) << "# nothing\n";
  std::ofstream(path("log.txt")) << "EDGE2 1 0 1 0 0 1 0 1 1 0 0\n";
  for (const char* file : {"empty.g2o", "log.txt", "missing.g2o"}) {
    const Ended ended = call_ranks(2, {"run", path(file)});
    EXPECT_EQ(ended.exit_code, 3) << file;
    EXPECT_THAT(ended.err, HasSubstr(file));
  }
  EXPECT_THAT(call_ranks(2, {"run", path("log.txt")}).err,
              HasSubstr("`mapjoin convert` writes one, or `mapjoin build` a store for `mapjoin-mpi join`"));
}

TEST_F(RunOnRanks, ReadsACompressedLog) {
  const std::string log = data_file("pose-graphs-2d/intel.g2o.gz").string();
  EXPECT_EQ(report_of_ranks(2, {"run", log})["chi2"], report_of_ranks(2, {"run", converted(log)})["chi2"]);
}

TEST_F(RunOnRanks, RefusesMoreRanksThanTheLogIsWorth) {
  std::ofstream(path("small.g2o")) << kSmallLog;
  const Ended ended = call_ranks(2, {"run", path("small.g2o")});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err,
              HasSubstr("3 poses are too few for 2 ranks: take fewer, or `mapjoin run` or, of stores, `mapjoin join`"));
  EXPECT_THAT(call_ranks(1, {"run", path("small.g2o")}).err,
              HasSubstr("3 poses are too few for 1 rank: take `mapjoin run` or"));
  for (const std::string many : {"1000", "4611686018427387904"}) {  // the latter so that 20 times as many would be none
    const Ended regions = call_ranks(2, {"run", bundled("manhattan2d.g2o"), "--regions", many});
    EXPECT_EQ(regions.exit_code, 2);
    EXPECT_THAT(regions.err, HasSubstr("are too few for 2 ranks of " + many + " regions"));
  }
}

TEST_F(RunOnRanks, RefusesFactorsThatAreTooLargeWithNumbers) {
  for (const char* regions : {"1", "4"}) {
    const Ended ended = call_ranks(2, {"run", bundled("manhattan3d.g2o"), "--max-memory", "0.5", "--regions", regions});
    EXPECT_EQ(ended.exit_code, 6);
    EXPECT_THAT(ended.err, HasSubstr("of --max-memory"));
  }
}

TEST_F(RunOnRanks, TakesALogOfWhichARankHasFixedPosesAlone) {
  std::ofstream file(path("known.g2o"));
  for (int k = 0; k < 120; ++k) file << "VERTEX_SE2 " << k << ' ' << k << " 0 0\n";
  for (int k = 119; k >= 20; --k) file << "FIX " << k << '\n';
  for (int k = 1; k < 120; ++k) file << "EDGE_SE2 " << k - 1 << ' ' << k << " 1 " << k % 3 * 0.1 << " 0 1 0 0 1 0 1\n";
  file.close();
  const auto one = report_of({"run", path("known.g2o"), "--no-verdict"});
  for (const char* regions : {"1", "2"}) {
    for (const int ranks : {2, 4}) {
      const auto found = report_of_ranks(ranks, {"run", path("known.g2o"), "--regions", regions});
      EXPECT_NEAR(found["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>()) << ranks << " of " << regions;
      EXPECT_EQ(found["dof"], one["dof"]);
    }
  }
}

TEST_F(RunOnRanks, TakesALogOfWhichARankHasVerticesOfFeaturesAlone) {
  std::ofstream file(path("seen.g2o"));
  const std::string blanks(200, ' ');  // make most of the file of the vertices of features
  for (int k = 0; k < 120; ++k) file << "VERTEX_SE2 " << k << ' ' << k << " 0 0\n";
  for (int k = 0; k < 120; ++k) file << "VERTEX_XY " << 1000 + k << ' ' << k << " 1" << blanks << '\n';
  for (int k = 0; k < 120; ++k) file << "EDGE_SE2_XY " << k << ' ' << 1000 + k << " 0 1 1 0 1\n";
  for (int k = 1; k < 120; ++k) file << "EDGE_SE2_XY " << k << ' ' << 999 + k << " -1 1 1 0 1\n";
  for (int k = 1; k < 120; ++k) file << "EDGE_SE2 " << k - 1 << ' ' << k << " 1 " << k % 3 * 0.1 << " 0 1 0 0 1 0 1\n";
  file.close();
  const auto one = report_of({"run", path("seen.g2o"), "--no-verdict"});
  const auto four = report_of_ranks(4, {"run", path("seen.g2o")});
  EXPECT_NEAR(four["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>());
  EXPECT_EQ(four["dof"], one["dof"]);
}

TEST_F(RunOnRanks, WantsAnExtensionOfTheMap) {
  for (const char* name : {"map", "map.txt"}) {
    const Ended ended = call_ranks(2, {"run", bundled("manhattan2d.g2o"), "-o", path(name)});
    EXPECT_EQ(ended.exit_code, 2) << name;
    EXPECT_THAT(ended.err, HasSubstr(path(name) + " has none of the extensions of a map, .g2o, .tum, .csv and .mat"));
    EXPECT_FALSE(std::filesystem::exists(path(name)));
  }
}

TEST_F(RunOnRanks, WantsAFolderForTheFactor) {
  const Ended ended = call_ranks(2, {"run", bundled("manhattan2d.g2o"), "--out-of-core", path("missing")});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, HasSubstr("missing is no folder"));
  const Ended no_room = call_ranks(2, {"run", bundled("manhattan2d.g2o"), "--out-of-core", "/proc"});
  EXPECT_EQ(no_room.exit_code, 5);
  EXPECT_THAT(no_room.err, HasSubstr("/proc: no room for a file of "));
}

TEST_F(RunOnRanks, SaysThatTheMapCannotBeWrittenBeforeTheWork) {
  const Ended ended = call_ranks(2, {"run", bundled("manhattan2d.g2o"), "-o", path("no/such/folder/map.g2o")});
  EXPECT_EQ(ended.exit_code, 5);
}

}  // namespace
}  // namespace mapjoin::testing
