// SPDX-License-Identifier: BSD-3-Clause
// Small logs that leave something free to move, each with its message.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/temporary_folder.hpp>
#include <variant>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// The error of a run on a log in the plane; empty if there is none.
std::string said_of(const std::string& g2o) {
  const testing::TemporaryFolder folder;
  const auto log = open_log(folder.file("log.g2o", g2o));
  return testing::error_of(run(std::get<Log<2>>(*log), RunOptions()));
}

TEST(FreeToMove, TwoSessionsWithOneFeatureTurnAboutIt) {
  EXPECT_THAT(
      said_of("EDGE_SE2 0 1 1 0 0 100 0 0 100 0 400\n"
              "EDGE_SE2 5 6 1 0 0 100 0 0 100 0 400\n"
              "EDGE_SE2_XY 1 7 0 1 25 0 25\n"
              "EDGE_SE2_XY 5 7 0 1 25 0 25\n"),
      HasSubstr("pose 5 and pose 6 cannot be determined: the observations leave them free to turn as a whole about feature 7"));
}

TEST(FreeToMove, APoseWithoutHeadingTurns) {
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\n"),
              HasSubstr("pose 1 cannot be determined: the observations leave it free to turn"));
}

TEST(FreeToMove, AllPosesWithoutHeadingAreCounted) {
  std::string chain;
  for (int pose = 0; pose < 30; ++pose) {
    chain += "EDGE_SE2 " + std::to_string(pose) + " " + std::to_string(pose + 1) + " 1 0 0 1 0 0 1 0 0\n";
  }
  EXPECT_THAT(said_of(chain), HasSubstr("pose 1, pose 2, pose 3 and 27 others cannot be determined"));
}

TEST(FreeToMove, AFeatureSeenAlongOneAxisMoves) {
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1 0 0 100 0 0 100 0 400\n"
                      "EDGE_SE2_XY 0 7 1 1 25 0 0\n"
                      "EDGE_SE2_XY 1 7 0 1 25 0 0\n"),
              HasSubstr("feature 7 cannot be determined: the observations leave it free to move"));
}

TEST(FreeToMove, WeightsTooFarApartAreNamed) {
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
                      "EDGE_SE2 1 2 1 0 0 1e100 0 0 1e100 0 1e100\n"
                      "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\n"),
              HasSubstr("weights from 1 to 1e+100 are too far apart"));
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\n"), Not(HasSubstr("weights")));
}

TEST(FreeToMove, WeightsADozenDigitsApartAreNot) {
  EXPECT_EQ(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
                    "EDGE_SE2 1 2 1 0 0 1e12 0 0 1e12 0 1e12\n"
                    "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\n"),
            "");
}

TEST(FreeToMove, OneEdgeIsEnough) {
  EXPECT_EQ(said_of("EDGE_SE2 0 1 1 0 0 100 0 0 100 0 400\n"), "");
}

}  // namespace
}  // namespace mapjoin
