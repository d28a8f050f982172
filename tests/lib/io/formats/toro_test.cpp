// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/geometry/euler.hpp>
#include <mapjoin/io/formats/angle_text.hpp>
#include <mapjoin/io/open.hpp>
#include <string>
#include <tests/support/error_of.hpp>
#include <tests/support/same_log.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using testing::error_of;
using ::testing::StartsWith;

Expected<AnyLog> read_toro(const std::string& text) {
  return read_edge_text(TextScanner("some.graph", text), kToroPlane, &kToroSpace, {});
}

const std::string kVertices = "VERTEX2 0 0 0 0\nVERTEX2 1 1 2 0.5\n";

TEST(Toro, ReadsThePlaneWithItsOwnOrderOfWeights) {
  const auto log = std::get<Log<2>>(read_toro(kVertices + "EDGE2 0 1 1 2 0.5 10 1 20 30 2 3\n").value());
  ASSERT_EQ(log.odometry().size(), 1u);
  EXPECT_EQ(log.odometry()[0].measured.translation, Point<2>(1, 2));
  EXPECT_EQ(log.odometry()[0].measured.rotation.angle(), 0.5);
  EXPECT_EQ(log.odometry()[0].information, (Matrix<3>() << 10, 1, 2, 1, 20, 3, 2, 3, 30).finished());
  ASSERT_EQ(log.initial.poses.size(), 2u);
  EXPECT_EQ(log.initial.poses[1].rotation.angle(), 0.5);
}

TEST(Toro, TakesAnglesInSpaceAsIsamDoes) {
  const std::string edge = "EDGE3 0 1 1 2 3 0.3 -0.8 2.5 ";
  // A diagonal square root, as iSAM has it, and its square, as TORO has it.
  const auto isam = std::get<Log<3>>(
      read_edge_text(TextScanner("a", edge + "1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6\n"), kIsamPlane, &kIsamSpace, {})
          .value());
  const auto toro = std::get<Log<3>>(read_toro("VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1 2 3 0.3 -0.8 2.5\n" + edge +
                                               "1 0 0 0 0 0 4 0 0 0 0 9 0 0 0 16 0 0 25 0 36\n")
                                         .value());
  testing::expect_same_log(isam, toro, {0.0, 1e-14});
  EXPECT_LE(local(toro.initial.poses[1], toro.odometry()[0].measured).norm(), 1e-15);
}

TEST(Toro, TellsRollAndYawApartNearARightAngle) {
  const auto log = std::get<Log<3>>(read_toro("VERTEX3 0 0 0 0 0.5 1.5706 0.25\nVERTEX3 1 1 0 0 0.5 1.5706 0.25\n"
                                              "EDGE3 0 1 1 0 0 0 0 0 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n")
                                        .value());
  const auto angles = pose_angles<3>(log.initial.poses[0]);
  ASSERT_TRUE(angles);
  EXPECT_LE((angles->numbers.tail<3>() - Vector<3>(0.5, 1.5706, 0.25)).norm(), 1e-9);
}

TEST(Toro, ReadsAndWritesAPoseAtARightAngleWhereItHasNoWeights) {
  const auto log =
      std::get<Log<3>>(read_toro("VERTEX3 0 1 2 3 0.5 1.5707963267948966 0.25\nVERTEX3 1 1 0 0 0 -1.5707963267948966 2\n"
                                 "EDGE3 0 1 1 0 0 0 0 0 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n")
                           .value());
  EXPECT_TRUE(
      log.initial.poses[0].rotation.matrix().isApprox(rotation_from_euler(0.25, 1.5707963267948966, 0.0).matrix(), 1e-14))
      << "roll and yaw turn about one axis, either way";
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_edge_text(log, kToroSpace, folder.path() / "some.graph"));
  const auto again = std::get<Log<3>>(open_log(folder.path() / "some.graph").value());
  for (const PoseIndex p : indices(log.poses)) EXPECT_LE(local(again.initial.poses[p], log.initial.poses[p]).norm(), 1e-14);
}

TEST(Toro, IsToldFromIsamByItsVerticesWhereverTheyStand) {
  const testing::TemporaryFolder folder;
  const std::string edge = "EDGE2 0 1 1 2 0.5 10 0 20 30 0 1\n";
  const auto toro = open_log(folder.file("toro", edge + kVertices));
  EXPECT_EQ(std::get<Log<2>>(toro.value()).odometry()[0].information(2, 2), 30.0);
  const auto isam = open_log(folder.file("isam", edge));
  EXPECT_EQ(std::get<Log<2>>(isam.value()).odometry()[0].information(1, 1), 900.0);
}

TEST(Toro, LeavesOutAndCountsEquivalencesAndBearings) {
  const auto log = std::get<Log<2>>(
      read_toro(kVertices + "EQUIV 0 1\nBR 0 7 0.1 2 0.1 0.1\nEDGE2 0 1 1 2 0.5 10 1 20 30 2 3\nEQUIV 1 0\n").value());
  EXPECT_EQ(log.odometry().size(), 1u);
  EXPECT_EQ(log.skipped, (SkipCounts{{"BR lines", 1}, {"EQUIV lines", 2}}));
}

TEST(Toro, TakesTheIdentityForMissingWeightsIfAsked) {
  const std::string text = "VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1 0 0 0 0 0\nEDGE3 0 1 1 0 0 0 0 0\n";
  EXPECT_EQ(
      error_of(read_toro(text)),
      "some.graph:3:22: the line ends where its weights are expected; --identity-where-missing takes the identity for them");
  const auto log = std::get<Log<3>>(
      read_edge_text(TextScanner("some.graph", text), kToroPlane, &kToroSpace, {.identity_where_missing = true}).value());
  EXPECT_TRUE(log.odometry()[0].information.isIdentity(1e-15));
  EXPECT_EQ(log.conventions.repairs.missing, 1);
}

TEST(Toro, NamesThePlaceOfWhatIsWrong) {
  EXPECT_EQ(error_of(read_toro(kVertices + "EDGE2 0 1 1 2\n")), "some.graph:3:14: the line ends where a number is expected");
  EXPECT_EQ(error_of(read_toro(kVertices + "EDGE2 0 1 1 nan 0 1 0 1 1 0 0\n")),
            "some.graph:3:13: 'nan' stands where a number is expected");
  EXPECT_THAT(error_of(read_toro(kVertices + "EDGE2 0 1 1 2 0 1 0 -1 1 0 0\n")),
              StartsWith("some.graph:3:1: the information matrix of the edge from pose 0 to pose 1 is indefinite"));
  EXPECT_EQ(
      error_of(read_toro(kVertices + "EDGE2 0 9 1 2 0 1 0 1 1 0 0\n")),
      "some.graph:3:1: the file declares vertices, but not pose 9; give the file that does as FURTHER, or --skip-undeclared");
  EXPECT_EQ(error_of(read_toro(kVertices + "VERTEX2 1 0 0 0\n")),
            "some.graph:3:1: pose 1 is declared a second time; two logs in one file are to be given as two files");
  EXPECT_EQ(error_of(read_toro(kVertices + "EQUIVALENT 0 1\n")),
            "some.graph:3:1: unknown tag 'EQUIVALENT'; --skip-unknown leaves such lines out");
  EXPECT_EQ(error_of(read_toro(kVertices + "EDGE2 1 1 1 2 0 1 0 1 1 0 0\n")),
            "some.graph:3:1: an edge leads from pose 1 to itself; --skip-self-edges leaves such edges out");
}

}  // namespace
}  // namespace mapjoin
