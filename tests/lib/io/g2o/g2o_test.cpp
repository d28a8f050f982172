// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/g2o/g2o.hpp>
#include <string>
#include <tests/support/error_of.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/same_log.hpp>
#include <tests/support/temporary_folder.hpp>
#include <vector>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kEdge2 = "EDGE_SE2 0 1 1 0 0.1 1 0 0 1 0 1\n";
const std::string kIdentity6 = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";

Expected<AnyLog> read(const std::string& text, const ReadOptions& options = {}) {
  return read_g2o(TextScanner("some.g2o", text), options);
}

template <int Dim>
Log<Dim> read_as(const std::string& text, const ReadOptions& options = {}) {
  auto log = read(text, options);
  if (log) return std::get<Log<Dim>>(*std::move(log));
  ADD_FAILURE() << log.error().message;
  return {};
}

std::string message(const std::string& text, const ReadOptions& options = {}) {
  return testing::error_of(read(text, options));
}

TEST(G2o, ReadsEveryTagOfThePlane) {
  const auto log = read_as<2>(
      "VERTEX_SE2 4 1 2 0.5\n"
      "VERTEX_XY 4 7 8\n"
      "FIX 4\n"
      "VERTEX_SE2 9 3 4 7.5\n"
      "EDGE_SE2_XY 9 4 -1 -2 2 0.5 3\n"
      "EDGE_SE2 9 4 0.25 -0.5 7 1 0.1 0.2 2 0.3 3\n");
  EXPECT_THAT(log.poses, ElementsAre(PoseId{0, 4}, PoseId{0, 9}));
  EXPECT_THAT(log.features, ElementsAre(FeatureId{4}));
  EXPECT_EQ(log.initial.poses.at(1).translation, Point<2>(3, 4));
  EXPECT_EQ(log.initial.poses[1].rotation.angle(), 7.5) << "headings are not wrapped";
  EXPECT_EQ(log.initial.features.at(0), Point<2>(7, 8));
  EXPECT_EQ(log.graph.fixed.at(0).pose, PoseIndex(0));
  EXPECT_EQ(log.graph.fixed[0].value.translation, Point<2>(1, 2));
  EXPECT_EQ(log.odometry()[0].base, PoseIndex(1));
  EXPECT_EQ(log.odometry()[0].target, PoseIndex(0));
  EXPECT_EQ(log.odometry()[0].measured.translation, Point<2>(0.25, -0.5));
  EXPECT_EQ(log.odometry()[0].measured.rotation.angle(), 7.0);
  const Matrix<3> W = (Matrix<3>() << 1, 0.1, 0.2, 0.1, 2, 0.3, 0.2, 0.3, 3).finished();
  EXPECT_EQ(log.odometry()[0].information, W);
  EXPECT_EQ(log.observations()[0].base, PoseIndex(1));
  EXPECT_EQ(log.observations()[0].measured, Point<2>(-1, -2));
  EXPECT_EQ(log.observations()[0].information, (Matrix<2>() << 2, 0.5, 0.5, 3).finished());
}

TEST(G2o, FixesSeveralPosesOnOneLineAndNamesAWordThatIsNone) {
  const auto log = read_as<2>("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nFIX 0 1\n" + kEdge2);
  EXPECT_EQ(log.graph.fixed.size(), 2u);
  EXPECT_THAT(message("FIX 0 1\n" + kEdge2), HasSubstr("some.g2o:1:7: pose 1 is fixed beside pose 0, but nothing says where"));
  EXPECT_EQ(message("FIX a b\n" + kEdge2), "some.g2o:1:5: 'a' stands where an id is expected");
  EXPECT_EQ(message("FIX 0 -1 1\n" + kEdge2), "some.g2o:1:7: '-1' stands where an id is expected");
}

TEST(G2o, AnInformationMatrixPassesAsItIsTurned) {
  // The negative eigenvalue is rounding beside the largest entry, 1, but not beside 0.25, as which the quaternion counts
  // rotations.
  const std::string edge = "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 -9e-14 0 0 0 0 0 1e-3 0 0 0 0 1e-3 0 0 0 1 0 0 1 0 1\n";
  EXPECT_EQ(message(edge), "");
  EXPECT_THAT(message(edge, {.rotation_information = RotationInformation::kQuaternion}), HasSubstr("is indefinite"));
}

TEST(G2o, ReadsEveryTagOfSpaceAndAppliesSensorOffsetsGivenLater) {
  const auto log = read_as<3>(
      "EDGE_SE3_TRACKXYZ 7 9 3 2 1 3 1 0 0 2 0 3\n"
      "VERTEX_TRACKXYZ 9 0 0 3.5\n"
      "VERTEX_SE3:QUAT 7 1 -2 0.5 0 0 0 1\n"
      "VERTEX_SE3:QUAT 8 1 -2 0.5 0 0 0.6 0.8\n"
      "EDGE_SE3:QUAT 7 8 1 2 3 0 0 1.2 1.6" +
      kIdentity6 +
      "PARAMS_CAMERACALIB 5 nobody names this\n"
      "PARAMS_SE3OFFSET 3 10 20 30 0 0 0.7071067811865476 0.7071067811865476\n");
  const auto& observation = log.observations()[0];
  // The sensor is turned by a quarter about z: its x is the robot's y, its y the robot's -x.
  EXPECT_TRUE(observation.measured.isApprox(Point<3>(10 - 1, 20 + 2, 30 + 3), 1e-15));
  EXPECT_TRUE(observation.information.isApprox(Vector<3>(2, 1, 3).asDiagonal().toDenseMatrix(), 1e-15));
  EXPECT_TRUE(log.odometry()[0].measured.rotation.quaternion().coeffs().isApprox(Vector<4>(0, 0, 0.6, 0.8), 1e-15));
  EXPECT_EQ(log.odometry()[0].measured.translation, Point<3>(1, 2, 3));
  EXPECT_EQ(log.initial.features.at(0), Point<3>(0, 0, 3.5));
}

TEST(G2o, NamesPosesAndFeaturesByEdgesWhereThereAreNoVertices) {
  const auto log = read_as<2>(kEdge2 + "EDGE_SE2_XY 1 0 2 3 1 0 1\n");
  EXPECT_EQ(log.poses.size(), 2u);
  EXPECT_THAT(log.features, ElementsAre(FeatureId{0}));
  EXPECT_TRUE(log.initial.poses.empty());
}

TEST(G2o, RecordsTheConventionsAndTurnsTheInformationWithThem) {
  const ReadOptions options{PoseError::kG2o, RotationInformation::kQuaternion, false};
  const auto log = read_as<3>("EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1" + kIdentity6, options);
  EXPECT_EQ(log.conventions.pose_error, PoseError::kG2o);
  EXPECT_EQ(log.conventions.rotation_information, RotationInformation::kQuaternion);
  EXPECT_EQ(log.odometry()[0].information.diagonal(), (Vector<6>() << 1, 1, 1, 0.25, 0.25, 0.25).finished());
  // In the plane there is no quaternion to weigh.
  EXPECT_EQ(read_as<2>(kEdge2, options).conventions.rotation_information, RotationInformation::kVector);
}

TEST(G2o, RefusesToTurnTheInformationOfAFileItWroteASecondTime) {
  const testing::TemporaryFolder folder;
  const auto file = folder.path() / "turned.g2o";
  const ReadOptions of_error{.pose_error = PoseError::kG2o};
  const ReadOptions of_quaternion{.rotation_information = RotationInformation::kQuaternion};
  const auto log = read_as<3>("EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1" + kIdentity6, of_quaternion);
  ASSERT_TRUE(write_g2o<3>(log, file));
  const std::string written = testing::bytes_of(file);
  EXPECT_EQ(read_as<3>(written).odometry()[0].information, log.odometry()[0].information);
  for (const ReadOptions& options : {of_error, of_quaternion}) {
    const auto again = read(written, options);
    ASSERT_FALSE(again);
    EXPECT_EQ(again.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(message(written, options), HasSubstr("some.g2o: says what its information matrices weigh"));
  }
}

TEST(G2o, NamesTheLineAndColumnOfAMalformedNumber) {
  EXPECT_EQ(message(kEdge2 + "EDGE_SE2 1 2 0.1 x.5 0 1 0 0 1 0 1\n"), "some.g2o:2:18: 'x.5' stands where a number is expected");
  EXPECT_EQ(message("EDGE_SE2 0 1 1 0"), "some.g2o:1:17: the line ends where a number is expected");
  EXPECT_EQ(message("EDGE_SE2 -1 1 1 0 0 1 0 0 1 0 1"), "some.g2o:1:10: '-1' stands where an id is expected");
  EXPECT_EQ(message("VERTEX_SE2 0 0 0 0 0"), "some.g2o:1:20: '0' stands where the line should end");
}

TEST(G2o, ReadsALongFileInPiecesAndNamesTheFirstFaultOfSeveral) {
  // Some megabytes, many times what is read at once.
  std::vector<std::string> lines;
  for (int k = 0; k < 100000; ++k) {
    lines.push_back("EDGE_SE2 " + std::to_string(k) + " " + std::to_string(k + 1) + " 1.0000000000001 0.5 0.1 1 0 0 1 0 1\n");
  }
  const auto joined = [&] {
    std::string text;
    for (const auto& line : lines) text += line;
    return text;
  };
  const auto log = read_as<2>(joined());
  ASSERT_EQ(log.odometry().size(), 100000u);
  for (std::size_t k = 0; k < log.odometry().size(); ++k) {
    EXPECT_EQ(log.odometry()[k].target, PoseIndex(k + 1));
  }
  lines[99990] = "EDGE_SE2 5\n";
  lines[77777] = "EDGE_SE2 5 6 1 0 0.1 1 0 0 1 0 one\n";
  lines[88888] = "NO_TAG\n";
  EXPECT_THAT(message(joined()), HasSubstr("some.g2o:77778:32: 'one'"));
}

TEST(G2o, InPiecesOfAnySizeTheLogIsTheSame) {
  const std::string text =
      kEdge2 + "VERTEX_SE2 1 1 0 0\n# a comment\nVERTEX_SE2 0 0 0 0\nVERTEX_XY 7 1 1\nEDGE_SE2_XY 1 7 1 0 2 0 2\nFIX 0\n";
  const auto whole = read_as<2>(text);
  for (std::size_t bytes = 1; bytes <= text.size(); ++bytes) {
    const auto log = std::get<Log<2>>(read_g2o(TextScanner("some.g2o", text), {}, {.piece_bytes = bytes}).value());
    testing::expect_same_log(log, whole);
    EXPECT_EQ(log.graph.fixed.size(), 1u);
    EXPECT_EQ(log.initial.poses.size(), 2u);
  }
}

TEST(G2o, NamesAnUnknownTag) {
  EXPECT_EQ(message(kEdge2 + "EDGE_SE2_OFFSET 1 2"),
            "some.g2o:2:1: unknown tag 'EDGE_SE2_OFFSET'; --skip-unknown leaves such lines out");
  EXPECT_EQ(message("hello world"), "some.g2o:1:1: unknown tag 'hello'; --skip-unknown leaves such lines out");
}

TEST(G2o, RefusesToMixDimensions) {
  EXPECT_EQ(message(kEdge2 + "VERTEX_TRACKXYZ 1 0 0 0"),
            "some.g2o:2:1: VERTEX_TRACKXYZ in a file of dimension 2; --skip-unknown leaves such lines out");
  EXPECT_EQ(message("VERTEX_TRACKXYZ 1 0 0 0\n" + kEdge2),
            "some.g2o:2:1: EDGE_SE2 in a file of dimension 3; --skip-unknown leaves such lines out");
}

TEST(G2o, NamesAnEdgeToAnIdThatNoVertexDeclares) {
  const std::string vertices = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 5 1 1\n";
  EXPECT_EQ(message(vertices + kEdge2), "");
  EXPECT_EQ(
      message(vertices + kEdge2 + "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1"),
      "some.g2o:5:1: the file declares vertices, but not pose 2; give the file that does as FURTHER, or --skip-undeclared");
  EXPECT_EQ(
      message(vertices + "EDGE_SE2_XY 1 6 1 0 1 0 1"),
      "some.g2o:4:1: the file declares vertices, but not feature 6; give the file that does as FURTHER, or --skip-undeclared");
  EXPECT_EQ(
      message("EDGE_SE2_XY 7 5 1 0 1 0 1\n" + vertices),
      "some.g2o:1:1: the file declares vertices, but not pose 7; give the file that does as FURTHER, or --skip-undeclared");
}

TEST(G2o, NamesAVertexDeclaredTwice) {
  EXPECT_EQ(message("VERTEX_SE2 1 0 0 0\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0 0\n"),
            "some.g2o:3:1: pose 1 is declared a second time; two logs in one file are to be given as two files");
  EXPECT_EQ(message("VERTEX_SE2 1 0 0 0\nVERTEX_XY 1 0 0\nVERTEX_XY 1 0 0\n"),
            "some.g2o:3:1: feature 1 is declared a second time; two logs in one file are to be given as two files");
}

TEST(G2o, NamesAnEdgeFromAPoseToItself) {
  EXPECT_EQ(message("EDGE_SE2 3 3 1 0 0 1 0 0 1 0 1"),
            "some.g2o:1:1: an edge leads from pose 3 to itself; --skip-self-edges leaves such edges out");
}

TEST(G2o, NamesTheEdgeOfAnIndefiniteInformationOrRepairsIt) {
  const std::string text = kEdge2 + "EDGE_SE2_XY 1 4 1 0 1 2 1\n";
  EXPECT_EQ(message(text),
            "some.g2o:2:1: the information matrix of the observation of feature 4 from pose 1 is indefinite (eigenvalues from "
            "-1 to 3); "
            "--repair-information takes the nearest semidefinite one");
  const auto log = read_as<2>(text, {.repair_information = true});
  EXPECT_EQ(log.conventions.repairs.indefinite, 1);
  EXPECT_TRUE(log.observations()[0].information.isApprox(Matrix<2>::Constant(1.5), 1e-14));
}

TEST(G2o, RefusesToFixAFeature) {
  EXPECT_THAT(message("VERTEX_SE2 0 0 0 0\nVERTEX_XY 5 1 1\nFIX 5\n"),
              HasSubstr("a feature is not fixed, but held by a prior"));
}

TEST(G2o, AFixNamesAPose) {
  EXPECT_THAT(message(kEdge2 + "FIX\n"), HasSubstr("2:4: the line ends where an id is expected"));
}

TEST(G2o, NamesASensorOffsetThatIsMissingOrGivenTwice) {
  const std::string offset = "PARAMS_SE3OFFSET 1 0 0 0 0 0 0 1\n";
  const std::string edge = "EDGE_SE3_TRACKXYZ 0 1 2 1 1 1 1 0 0 1 0 1\n";
  EXPECT_EQ(message(offset + edge), "some.g2o:2:23: no PARAMS_SE3OFFSET line gives the sensor offset 2");
  EXPECT_EQ(message(offset + offset + edge),
            "some.g2o:2:18: sensor offset 1 is given a second time; if these are two logs, give them as two files");
}

TEST(G2o, RefusesAnObservationThatLeavesTheRangeOfNumbersInTheFrameOfItsPose) {
  const std::string turned = "PARAMS_SE3OFFSET 1 0 0 0 0 0 0.3826834323650898 0.9238795325112867\n";
  const std::string edge = "EDGE_SE3_TRACKXYZ 0 7 1 1.7e308 -1.7e308 0 1 0 0 1 0 1\n";
  EXPECT_EQ(message(turned + edge), "some.g2o:2:1: feature 7 is too far away");
}

TEST(G2o, RefusesAQuaternionThatIsNone) {
  EXPECT_EQ(message("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0"), "some.g2o:1:31: the four numbers up to here are not a unit quaternion");
  EXPECT_EQ(message("VERTEX_SE3:QUAT 0 0 0 0 0.1 0.1 0.1 0.1"),
            "some.g2o:1:37: the four numbers up to here are not a unit quaternion");
}

TEST(G2o, BringsAQuaternionOfALengthFromAHalfToTwoToUnitLength) {
  for (const char* w : {"0.5", "2"}) {
    const auto log = read_as<3>(std::string("VERTEX_SE3:QUAT 0 1 2 3 0 0 0 ") + w + "\n");
    EXPECT_EQ(log.initial.poses.at(0).rotation.quaternion().w(), 1.0) << w;
  }
}

TEST(G2o, RefusesAFileWithoutPoses) {
  EXPECT_EQ(message("# nothing\n"), "some.g2o: the log has no poses");
  EXPECT_EQ(message("VERTEX_XY 0 1 2\n"), "some.g2o: the log has no poses");
}

TEST(G2o, TakesSomeLinesOfFeaturesAlone) {
  const auto log = read_g2o(TextScanner("some.g2o", "VERTEX_XY 0 1 2\n"), {}, {.is_whole = false, .needs_poses = false});
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_EQ(std::get<Log<2>>(*log).features.size(), 1U);
}

}  // namespace
}  // namespace mapjoin
