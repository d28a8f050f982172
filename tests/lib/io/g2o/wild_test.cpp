// SPDX-License-Identifier: BSD-3-Clause
// Lines in files of other programs that a log has no place for: passed over, refused with the option that goes on, or left out
// and counted if that is asked for. Priors of poses, features and sensors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/g2o/g2o.hpp>
#include <string>
#include <tests/support/error_of.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

const std::string kVertices = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";
const std::string kEdge = "EDGE_SE2 0 1 1 0 0.1 1 0 0 1 0 1\n";

Log<2> read_wild(const std::string& text, const ReadOptions& options = {}) {
  return std::get<Log<2>>(read_g2o(TextScanner("some.g2o", text), options).value());
}

std::string wild_error(const std::string& text, const ReadOptions& options = {}) {
  return testing::error_of(read_g2o(TextScanner("some.g2o", text), options));
}

TEST(WildG2o, PassesOverAndCountsDataOfSensors) {
  const auto log =
      read_wild(kVertices + "LASER_ROBOT_DATA 1 -1.57 3 hokuyo\n" + kEdge + "ROBOTLASER1 0 1 2\nROBOTLASER1 0 1 2\n");
  EXPECT_EQ(log.odometry().size(), 1u);
  EXPECT_EQ(log.skipped, (SkipCounts{{"LASER_ROBOT_DATA lines", 1}, {"ROBOTLASER1 lines", 2}}));
}

TEST(WildG2o, LeavesOutAndCountsUnknownLinesIfAsked) {
  const std::string text = kEdge + "EDGE_SE2_OFFSET 1 2\nThis line is not supported\nVERTEX_TRACKXYZ 2 0 0 0\n";
  EXPECT_THAT(wild_error(text), HasSubstr("unknown tag 'EDGE_SE2_OFFSET'; --skip-unknown"));
  EXPECT_EQ(read_wild(text, {.skip_unknown = true}).skipped,
            (SkipCounts{{"EDGE_SE2_OFFSET lines", 1}, {"This lines", 1}, {"VERTEX_TRACKXYZ lines", 1}}));
}

TEST(WildG2o, LeavesOutSelfEdgesIfAsked) {
  const std::string text = kEdge + "EDGE_SE2 1 1 0 0 0 1 0 0 1 0 1\n";
  EXPECT_THAT(wild_error(text), HasSubstr("an edge leads from pose 1 to itself; --skip-self-edges"));
  const auto log = read_wild(text, {.skip_self_edges = true});
  EXPECT_EQ(log.edges().size(), 1u);
  EXPECT_EQ(log.skipped, (SkipCounts{{"self-edges", 1}}));
}

TEST(WildG2o, TakesTheIdentityForMissingWeightsIfAsked) {
  const std::string text = "EDGE_SE2 0 1 1 0 0.1\nEDGE_SE2_XY 0 7 1 0\n" + kEdge;
  EXPECT_THAT(wild_error(text), HasSubstr("1:21: the line ends where its weights are expected; --identity-where-missing"));
  const auto log = read_wild(text, {.identity_where_missing = true});
  EXPECT_TRUE(log.odometry()[0].information.isIdentity(0.0));
  EXPECT_TRUE(log.observations()[0].information.isIdentity(0.0));
  EXPECT_EQ(log.conventions.repairs.missing, 2);
  EXPECT_THAT(wild_error("EDGE_SE2 0 1 1 0\n", {.identity_where_missing = true}), HasSubstr("a number is expected"))
      << "the measurement is not missing";
}

TEST(WildG2o, LeavesOutWhatNamesUndeclaredVerticesIfAsked) {
  const std::string text = kVertices + kEdge + "EDGE_SE2 1 7061644215716937729 1 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 0 3 1 0 1 0 1\n" +
                           "EDGE_PRIOR_SE2 9 0 0 0 1 0 0 1 0 1\n";
  EXPECT_THAT(wild_error(text),
              HasSubstr("some.g2o:4:1: the file declares vertices, but not pose b1; give the file that does"));
  const auto log = read_wild(text, {.undeclared = Undeclared::kSkipped});
  EXPECT_THAT(log.poses, ElementsAre(PoseId{0, 0}, PoseId{0, 1}));
  EXPECT_THAT(log.features, SizeIs(0));
  EXPECT_EQ(log.graph.pose_factors.size(), 1u);
  EXPECT_EQ(log.initial.poses.size(), 2u);
  EXPECT_EQ(log.skipped, (SkipCounts{{"edges to undeclared vertices", 3}}));
}

TEST(WildG2o, LeavesOutFixedPosesThatAreUndeclaredIfAsked) {
  const std::string text = kVertices + kEdge + "FIX 1 9\nFIX 9\n";
  EXPECT_THAT(wild_error(text), HasSubstr("some.g2o:4:1: the file declares vertices, but not pose 9; give the file that does"));
  EXPECT_THAT(wild_error(text, {.undeclared = Undeclared::kForeign}), HasSubstr("some.g2o:4:1: "));
  const auto log = read_wild(text, {.undeclared = Undeclared::kSkipped});
  ASSERT_THAT(log.graph.fixed, SizeIs(1));
  EXPECT_EQ(log.graph.fixed.front().pose, PoseIndex(1));
  EXPECT_EQ(log.skipped, (SkipCounts{{"fixed vertices that are undeclared", 1}}));
  EXPECT_THAT(
      wild_error("VERTEX_XY 5 1 1\n" + text.substr(0, text.find("FIX")) + "FIX 5\n"),
      HasSubstr("some.g2o:5:5: pose 5 is fixed, but the log has no such pose (a feature is not fixed, but held by a prior)"));
  EXPECT_THAT(wild_error(kEdge + "FIX 0\n FIX 0 9\n"),
              HasSubstr("some.g2o:3:8: pose 9 is fixed, but the log has no such pose"));
}

TEST(WildG2o, KeepsEdgesToPosesOfOtherFilesApart) {
  const std::string text = kVertices + kEdge + "EDGE_SE2 1 7 3 0 0 1 0 0 1 0 1\n";
  const auto log = read_wild(text, {.undeclared = Undeclared::kForeign});
  ASSERT_THAT(log.foreign, SizeIs(1));
  EXPECT_EQ(log.foreign[0].target, (PoseId{0, 7}));
  EXPECT_EQ(log.foreign[0].measured.translation, Point<2>(3, 0));
  EXPECT_THAT(log.poses, SizeIs(2));
  EXPECT_THAT(wild_error(text + "EDGE_SE2_XY 0 3 1 0 1 0 1\n", {.undeclared = Undeclared::kForeign}), HasSubstr(":5:1: "));
}

TEST(WildG2o, PriorsOfThePlaneAreEdgesFromTheWorld) {
  const auto log = read_wild(kEdge +
                             "EDGE_PRIOR_SE2 1 5 6 0.5 1 2 3 14 5 16\nEDGE_PRIOR_SE2_XY 0 7 8 1 0.5 2\n"
                             "EDGE_SE2_XY 0 3 1 0 1 0 1\nEDGE_PRIOR_XY 3 9 10 4 0 5\n");
  ASSERT_THAT(log.pose_priors(), SizeIs(2));
  EXPECT_EQ(log.pose_priors()[0].target, PoseIndex(1));
  EXPECT_EQ(log.pose_priors()[0].measured.translation, Point<2>(5, 6));
  EXPECT_EQ(log.pose_priors()[0].measured.rotation.angle(), 0.5);
  EXPECT_EQ(log.pose_priors()[0].information, (Matrix<3>() << 1, 2, 3, 2, 14, 5, 3, 5, 16).finished());
  EXPECT_EQ(log.pose_priors()[1].information, (Matrix<3>() << 1, 0.5, 0, 0.5, 2, 0, 0, 0, 0).finished());
  ASSERT_THAT(log.feature_priors(), SizeIs(1));
  EXPECT_EQ(log.feature_priors()[0].measured, Point<2>(9, 10));
  EXPECT_EQ(log.feature_priors()[0].information, (Matrix<2>() << 4, 0, 0, 5).finished());
}

TEST(WildG2o, TurnsTheWeightsOfPriorsByTheConventionOfEdges) {
  const std::string prior = "EDGE_PRIOR_SE2 1 5 6 1.5707963267948966 1 0 0 4 0 9\n";
  const auto log = read_wild(kEdge + prior, {.pose_error = PoseError::kG2o});
  EXPECT_TRUE(log.pose_priors()[0].information.isApprox(Vector<3>(4, 1, 9).asDiagonal().toDenseMatrix(), 1e-12));
}

const std::string kEdge3 = "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
const std::string kPose3 = " 1 2 3 0 0 0.7071067811865476 0.7071067811865476";
const std::string kOffset = "PARAMS_SE3OFFSET 4 0.5 0.25 -1 0 0.6 0 0.8\n";

Log<3> read_space(const std::string& text) {
  return std::get<Log<3>>(read_g2o(TextScanner("some.g2o", text), {}).value());
}

TEST(WildG2o, PositionsInSpaceAreMeasuredAlone) {
  const auto log = read_space(kEdge3 + "EDGE_SE3_XYZ_PRIOR 1 99 5 6 7 1 0 0 2 0 3\nEDGE_SE3_PRIORXYZ 0 5 6 7 1 0 0 2 0 3\n" +
                              "EDGE_SE3_PRIORXY 0 5 6 1 0 2\nVERTEX_TRACKXYZ 7 0 0 0\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n" +
                              "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\nEDGE_POINTXYZ_PRIOR 7 1 2 3 1 0 0 1 0 1\n");
  ASSERT_THAT(log.pose_priors(), SizeIs(3));
  const Vector<6> all = (Vector<6>() << 1, 2, 3, 0, 0, 0).finished();
  EXPECT_EQ(Vector<6>(log.pose_priors()[0].information.diagonal()), all) << "whose sensor g2o ignores, too";
  EXPECT_EQ(Vector<6>(log.pose_priors()[1].information.diagonal()), all);
  EXPECT_EQ(Vector<6>(log.pose_priors()[2].information.diagonal()), (Vector<6>() << 1, 2, 0, 0, 0, 0).finished());
  EXPECT_EQ(log.pose_priors()[2].measured.translation, Point<3>(5, 6, 0));
  EXPECT_THAT(log.feature_priors(), SizeIs(1));
}

TEST(WildG2o, ThePriorOfASensorBecomesThatOfItsRobot) {
  // The cost of the robot's pose is, to first order, that of the sensor's pose weighted by the matrix in the file.
  const std::string weights = " 10 0 0 0 1 0 20 0 0 0 0 30 0 0 0 40 0 0 50 0 60\n";
  const auto prior = read_space(kOffset + kEdge3 + "EDGE_SE3_PRIOR 1 4" + kPose3 + weights).pose_priors()[0];
  const auto plain =
      read_space("PARAMS_SE3OFFSET 4 0 0 0 0 0 0 1\n" + kEdge3 + "EDGE_SE3_PRIOR 1 4" + kPose3 + weights).pose_priors()[0];
  const Pose<3> sensor{{0.5, 0.25, -1}, Rotation<3>(Eigen::Quaterniond(0.8, 0, 0.6, 0))};
  EXPECT_LE(local(compose(prior.measured, sensor), plain.measured).norm(), 1e-14);
  for (int i = 0; i < 6; ++i) {
    const Pose<3> robot = retract<3>(prior.measured, 1e-6 * Vector<6>::Unit(i));
    const Vector<6> of_robot = local(robot, prior.measured);
    const Vector<6> of_sensor = local(compose(robot, sensor), plain.measured);
    const double as_seen = of_sensor.dot(plain.information * of_sensor);
    EXPECT_NEAR(of_robot.dot(prior.information * of_robot), as_seen, 1e-5 * as_seen) << i;
  }
  EXPECT_THAT(wild_error(kOffset + kEdge3 + "EDGE_SE3_PRIOR 1 4" + kPose3 + " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 0 0 0 0 0 0\n"),
              HasSubstr("the prior of a sensor away from its pose must measure its rotation"));
  EXPECT_THAT(wild_error(kEdge3 + "EDGE_SE3_PRIOR 1 4" + kPose3 + weights), HasSubstr("gives the sensor offset 4"));
}

}  // namespace
}  // namespace mapjoin
