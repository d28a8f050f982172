// SPDX-License-Identifier: BSD-3-Clause
// Logs of a rare kind: several ranks map them as one process does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <tests/mpi/ranks_test.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

class UnusualLogsOnRanks : public RanksTest {};

TEST_F(UnusualLogsOnRanks, MayHaveAFeatureThatOnlyAPriorMeasures) {
  std::ofstream(path("prior.g2o")) << content_of(bundled("manhattan2d.g2o"))
                                   << "EDGE_PRIOR_XY 9000 5 5 4 0 4\nEDGE_PRIOR_XY 9000 6 5 4 0 4\n";
  const auto one = report_of({"run", path("prior.g2o"), "--no-verdict"});
  for (const int ranks : {1, 2}) {
    for (const char* regions : {"1", "3"}) {
      const auto several = report_of_ranks(ranks, {"run", path("prior.g2o"), "--regions", regions});
      EXPECT_NEAR(several["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>()) << ranks << " of " << regions;
      EXPECT_EQ(several["dof"], one["dof"]) << ranks << " of " << regions;
    }
  }
}

TEST_F(UnusualLogsOnRanks, MayHaveAPoseThatManyAreMeasuredFrom) {
  for (const char* hub : {"0", "200", "399"}) {
    std::ofstream file(path("hub.g2o"));
    for (int k = 1; k < 400; ++k) file << "EDGE_SE2 " << k - 1 << ' ' << k << " 1 " << k % 3 * 0.1 << " 0 1 0 0 1 0 1\n";
    for (int k = 2; k < 398; k += 3) {
      if (std::abs(k - std::stoi(hub)) > 1)
        file << "EDGE_SE2 " << hub << ' ' << k << ' ' << k - std::stoi(hub) << " 0 0 1 0 0 1 0 1\n";
    }
    file.close();
    const auto one = report_of({"run", path("hub.g2o"), "--no-verdict"});
    for (const char* regions : {"1", "3"}) {
      const std::string summary =
          call_ranks(2, {"run", path("hub.g2o"), "--regions", regions, "--report", path("report.json")}).out;
      const auto several = nlohmann::json::parse(content_of(path("report.json")));
      EXPECT_NEAR(several["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>()) << hub << ", " << regions;
      std::smatch shared;
      ASSERT_TRUE(std::regex_search(summary, shared, std::regex("shared +[0-9]+ unknowns by ranks, ([0-9]+) by regions")))
          << summary;
      EXPECT_LT(std::stoi(shared[1]), 60) << hub << ", " << regions;
    }
  }
}

TEST_F(UnusualLogsOnRanks, MayBeginWithLongComments) {
  const std::string comments(100'000, '#');
  std::ofstream(path("long.g2o")) << comments << '\n' << content_of(bundled("manhattan2d.g2o"));
  EXPECT_EQ(report_of_ranks(2, {"run", path("long.g2o")})["poses"], 1000);
}

TEST_F(UnusualLogsOnRanks, MayHaveAFixedPoseThatNothingIsMeasuredFrom) {
  std::ofstream file(path("lone.g2o"));
  for (int k = 0; k < 60; ++k) file << "VERTEX_SE2 " << k << ' ' << k << " 0 0\n";
  for (int k = 1; k < 60; ++k) file << "EDGE_SE2 " << k - 1 << ' ' << k << " 1 " << k % 3 * 0.1 << " 0 1 0 0 1 0 1\n";
  file << "EDGE_SE2 0 59 59 0 0 1 0 0 1 0 1\nVERTEX_SE2 100 7 8 1\nFIX 0 100\n";
  file.close();
  const auto one = report_of({"run", path("lone.g2o"), "--no-verdict"});
  for (const int ranks : {1, 2}) {
    for (const char* regions : {"1", "2"}) {
      const auto several = report_of_ranks(ranks, {"run", path("lone.g2o"), "-o", path("map.csv"), "--regions", regions});
      for (const char* what : {"dof", "gauge"}) EXPECT_EQ(several[what], one[what]) << ranks << " of " << regions;
      EXPECT_THAT(content_of(path("map.csv")), HasSubstr("\n100,7,8,1\n")) << ranks << " of " << regions;
    }
  }
}

TEST_F(UnusualLogsOnRanks, MayBeDrivenPastThePoseWhereSharesMeet) {
  std::ofstream file(path("spur.g2o"));
  const auto drive = [&](int from, int to) { file << "EDGE_SE2 " << from << ' ' << to << " 1 0 0.05 1 0 0 1 0 1\n"; };
  for (int k = 0; k < 58; ++k) drive(k, k + 1);
  drive(58, 60);  // from where the first of two shares ends
  drive(60, 59);
  for (int k = 60; k < 119; ++k) drive(k, k + 1);
  file.close();
  EXPECT_LT(report_of_ranks(2, {"run", path("spur.g2o")})["join"]["turned"], 1e-3) << "the start is the optimum";
}

}  // namespace
}  // namespace mapjoin::testing
