// SPDX-License-Identifier: BSD-3-Clause
// Faults of a log that one process names with their place or their remedy: several name them alike.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <tests/mpi/ranks_test.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

class FaultsOnRanks : public RanksTest {};

TEST_F(FaultsOnRanks, SaysWhereWhatIsUndeclaredIsNamedOrLeavesItOut) {
  ASSERT_EQ(call({"run", bundled("manhattan2d.g2o"), "-o", path("map.g2o"), "--no-verdict"}).exit_code, 0);
  const std::string map = content_of(path("map.g2o"));
  const std::string log = path("more.g2o");
  std::ofstream(log) << map << "EDGE_SE2 10 5000 1 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 10 6000 1 1 1 0 1\n";
  const auto one = report_of({"run", log, "--skip-undeclared", "--no-verdict"});
  for (const int ranks : {1, 2}) {
    const Ended ended = call_ranks(ranks, {"run", log});
    EXPECT_EQ(ended.exit_code, 3);
    EXPECT_THAT(ended.err, HasSubstr(fmt::format("more.g2o:{}:1: the file declares vertices, but not pose 5000; "
                                                 "--skip-undeclared leaves such lines out\n",
                                                 count_of(map, "\n") + 1)));
    const auto several = report_of_ranks(ranks, {"run", log, "--skip-undeclared"});
    EXPECT_EQ(several["skipped"], one["skipped"]);
    EXPECT_NEAR(several["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>());
  }
  std::ofstream(path("feature.g2o")) << "VERTEX_XY 1 0 0\nEDGE_SE2_XY 0 1 1 1 1 0 1\n";
  EXPECT_THAT(call_ranks(1, {"run", path("feature.g2o"), "--skip-undeclared"}).err,
              HasSubstr("feature.g2o: the log has no poses\n"));
}

TEST_F(FaultsOnRanks, NamesAPoseThatIsFixedButNotThere) {
  std::ofstream file(path("fixed.g2o"));
  for (int k = 0; k < 40; ++k) file << "EDGE_SE2 " << k << ' ' << k + 1 << " 1 0 0 1 0 0 1 0 1\n";
  file << "FIX 99\n";
  file.close();
  const std::string sentence =
      "fixed.g2o:41:5: pose 99 is fixed, but the log has no such pose (a feature is not fixed, but held by a prior)\n";
  EXPECT_THAT(call({"run", path("fixed.g2o")}).err, HasSubstr(sentence));
  for (const int ranks : {1, 2}) EXPECT_THAT(call_ranks(ranks, {"run", path("fixed.g2o")}).err, HasSubstr(sentence));
}

TEST_F(FaultsOnRanks, NamesTheLineThatFixesASecondPoseWithoutAValue) {
  std::ofstream file(path("fixed.g2o"));
  file << "FIX 7\n";
  for (int k = 0; k < 40; ++k) file << "EDGE_SE2 " << k << ' ' << k + 1 << " 1 0 0 1 0 0 1 0 1\n";
  file << "FIX 7 3\n";
  file.close();
  const std::string sentence = "fixed.g2o:42:7: pose 3 is fixed beside pose 7, but nothing says where: ";
  EXPECT_THAT(call({"run", path("fixed.g2o")}).err, HasSubstr(sentence));
  for (const int ranks : {1, 2}) EXPECT_THAT(call_ranks(ranks, {"run", path("fixed.g2o")}).err, HasSubstr(sentence));
}

TEST_F(FaultsOnRanks, NamesTheLineThatFixesWhatIsUndeclaredOrLeavesItOut) {
  const std::string log = path("fixed.g2o");
  ASSERT_EQ(call({"run", bundled("manhattan2d.g2o"), "-o", path("map.g2o"), "--no-verdict"}).exit_code, 0);
  const std::string map = content_of(path("map.g2o"));
  std::ofstream(log) << map << "FIX 0 5000\n";
  const std::string place = fmt::format("fixed.g2o:{}:1: ", count_of(map, "\n") + 1);
  const auto one = report_of({"run", log, "--skip-undeclared", "--no-verdict"});
  EXPECT_EQ(one["skipped"]["fixed vertices that are undeclared"], 1);
  for (const int ranks : {1, 2}) {
    EXPECT_THAT(call_ranks(ranks, {"run", log}).err,
                HasSubstr(place + "the file declares vertices, but not pose 5000; --skip-undeclared leaves such lines out\n"));
    EXPECT_EQ(report_of_ranks(ranks, {"run", log, "--skip-undeclared"})["skipped"], one["skipped"]);
  }
}

TEST_F(FaultsOnRanks, RefusesNamesThatTheMapCannotHoldBeforeTheWork) {
  std::ofstream file(path("large.g2o"));
  for (std::uint64_t k = (std::uint64_t{1} << 53) - 2; k < (std::uint64_t{1} << 53) + 40; ++k) {
    file << "EDGE_SE2 " << k << ' ' << k + 1 << " 1 0 0 1 0 0 1 0 1\n";
  }
  file.close();
  const std::string sentence = "pose 9007199254740992 has an id of 2^53 or more, which a MAT file cannot say; .csv can\n";
  for (const int ranks : {1, 2}) {
    const Ended run = call_ranks(ranks, {"run", path("large.g2o"), "-o", path("map.mat"), "--checkpoint", path("stores")});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr(sentence));
    EXPECT_TRUE(std::filesystem::is_empty(path("stores")));
  }
  ASSERT_EQ(call_ranks(1, {"build", path("large.g2o"), "-o", path("stores")}).exit_code, 0);
  const Ended join = call_ranks(1, {"join", path("stores/1-of-1.maps"), "-o", path("map.mat")});
  EXPECT_EQ(join.exit_code, 2);
  EXPECT_THAT(join.err, HasSubstr(sentence));
}

TEST_F(FaultsOnRanks, SaysWhatIsFreeToMoveAsOneProcessDoes) {
  std::ofstream(path("axis.g2o")) << content_of(bundled("manhattan2d.g2o")) << "EDGE_SE2_XY 10 9000 3 1 25 0 0\n";
  const std::string of_feature = "axis.g2o: feature 9000 cannot be determined: the observations leave it free to move\n";
  EXPECT_THAT(call({"run", path("axis.g2o")}).err, HasSubstr(of_feature));
  for (const int ranks : {1, 2}) {
    for (const char* regions : {"1", "3"}) {
      const Ended ended = call_ranks(ranks, {"run", path("axis.g2o"), "--regions", regions});
      EXPECT_EQ(ended.exit_code, 3);
      EXPECT_THAT(ended.err, HasSubstr(of_feature)) << ranks << " of " << regions;
    }
  }
  std::ofstream turn(path("turn.g2o"));
  for (const int from : {0, 1, 2, 3, 4, 5, 6, 7, 8, 20}) {
    turn << "EDGE_SE2 " << from << ' ' << from + 1 << " 1 0 0 100 0 0 100 0 400\n";
  }
  turn << "EDGE_SE2_XY 1 7 0 1 25 0 25\nEDGE_SE2_XY 20 7 0 1 25 0 25\n";
  turn.close();
  EXPECT_THAT(call_ranks(1, {"run", path("turn.g2o")}).err,
              HasSubstr("turn.g2o: pose 20 and pose 21 cannot be determined: the observations leave them free to turn as a "
                        "whole about feature 7\n"));
}

}  // namespace
}  // namespace mapjoin::testing
