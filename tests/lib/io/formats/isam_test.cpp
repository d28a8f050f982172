// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/formats/angle_text.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <string>
#include <tests/support/error_of.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using testing::error_of;

Expected<AnyLog> read_isam(const std::string& text) {
  return read_edge_text(TextScanner("some.txt", text), kIsamPlane, &kIsamSpace, {});
}

TEST(Isam, ReadsThePlaneAndSquaresItsInformation) {
  const auto log = std::get<Log<2>>(
      read_isam("EDGE2 0 1 1 2 0.5 1 2 3 4 5 6\nLANDMARK 1 0 7 8 1 2 3\nEDGE2 1 2 1 2 -0.5 1 0 0 1 0 1\n").value());
  EXPECT_EQ(log.poses.size(), 3u);
  EXPECT_THAT(log.features, ElementsAre(FeatureId{0}));
  EXPECT_EQ(log.odometry()[0].measured.translation, Point<2>(1, 2));
  EXPECT_EQ(log.odometry()[0].measured.rotation.angle(), 0.5);
  const Matrix<3> S = (Matrix<3>() << 1, 2, 3, 0, 4, 5, 0, 0, 6).finished();
  EXPECT_EQ(log.odometry()[0].information, S.transpose() * S);
  EXPECT_EQ(log.observations()[0].base, PoseIndex(1));
  EXPECT_EQ(log.observations()[0].measured, Point<2>(7, 8));
  EXPECT_EQ(log.observations()[0].information, (Matrix<2>() << 1, 2, 2, 13).finished());
}

/// The rotation Rz(yaw) Ry(pitch) Rx(roll), written out.
Rotation<3> from_angles(const Vector<3>& angles) {
  const double cr = std::cos(angles[0]), sr = std::sin(angles[0]);
  const double cp = std::cos(angles[1]), sp = std::sin(angles[1]);
  const double cy = std::cos(angles[2]), sy = std::sin(angles[2]);
  return Rotation<3>((Matrix<3>() << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, sy * cp, sy * sp * sr + cy * cr,
                      sy * sp * cr - cy * sr, -sp, cp * sr, cp * cr)
                         .finished());
}

TEST(Isam, TurnsTheInformationOfEulerAnglesToTheRotationVectorAtTheMeasurement) {
  const auto log = std::get<Log<3>>(
      read_isam("EDGE3 0 1 1 2 3 0.3 -0.8 2.5 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21\n").value());
  const Vector<3> angles(0.3, -0.8, 2.5);
  const Rotation<3> R = from_angles(angles);
  const auto& edge = log.odometry()[0];
  EXPECT_EQ(edge.measured.translation, Point<3>(1, 2, 3));
  EXPECT_TRUE(edge.measured.rotation.matrix().isApprox(R.matrix(), 1e-14));

  Matrix<6> S = Matrix<6>::Zero();
  double entry = 0.0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) S(i, j) = ++entry;
  }
  const auto J_rotation_angles =
      testing::numerical_jacobian([&](const auto& d) { return (R.inverse() * from_angles(angles + d)).log(); }, 3);
  Matrix<6> J = Matrix<6>::Identity();
  J.bottomRightCorner<3, 3>() = J_rotation_angles;
  EXPECT_TRUE((J.transpose() * edge.information * J).isApprox(S.transpose() * S, 1e-8));
  EXPECT_EQ(edge.information, edge.information.transpose());
}

TEST(Isam, ReadsPointsInSpace) {
  const auto log = std::get<Log<3>>(read_isam("POINT3 4 4 1 2 3 1 0 0 2 0 3\n").value());
  EXPECT_EQ(log.observations()[0].measured, Point<3>(1, 2, 3));
  EXPECT_EQ(log.observations()[0].information.diagonal(), Vector<3>(1, 4, 9));
}

TEST(Isam, WritesZerosForWhatIsNotMeasuredButNotForWhatHardlyIs) {
  const auto last_number = [](const Matrix<2>& W) {
    LogBuilder<2> builder("memory");
    builder.add_observation({0, 0}, {0}, {1, 2}, W);
    const testing::TemporaryFolder folder;
    EXPECT_TRUE(write_edge_text(std::move(builder).finish().value(), kIsamPlane, folder.path() / "out"));
    const std::string text(FileBytes::read(folder.path() / "out").value().view());
    return text.substr(text.rfind(' ') + 1);
  };
  const Point<2> v(0.1, 0.7);  // rounding leaves some 1e-16 of the diagonal as the second pivot
  EXPECT_EQ(last_number(v * v.transpose()), "0\n");
  EXPECT_NE(last_number((Matrix<2>() << 1, 1, 1, 1 + 1e-10).finished()), "0\n");
}

TEST(Isam, NamesLineAndColumnOfWhatIsWrong) {
  const std::string good = "EDGE2 0 1 1 2 0.5 1 0 0 1 0 1\n";
  EXPECT_EQ(error_of(read_isam(good + "LANDMARK 1 0 7 8 1 2\n")), "some.txt:2:21: the line ends where a number is expected");
  EXPECT_EQ(error_of(read_isam(good + "POINT3 1 0 7 8 9 1 0 0 1 0 1\n")),
            "some.txt:2:1: unknown tag 'POINT3'; --skip-unknown leaves such lines out");
  EXPECT_EQ(error_of(read_isam("EDGE2 4 4 1 2 0.5 1 0 0 1 0 1\n")),
            "some.txt:1:1: an edge leads from pose 4 to itself; --skip-self-edges leaves such edges out");
  EXPECT_EQ(error_of(read_isam("LANDMARK 1 0 7 8 1e200 0 1\n")),
            "some.txt:1:1: the information matrix of the observation of feature 0 from pose 1 is not finite");
  EXPECT_EQ(
      error_of(read_isam("EDGE3 0 1 0 0 0 0 1.5707963267948966 0 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1")),
      "some.txt:1:19: at a pitch of a right angle weights of roll and yaw say nothing; g2o files weigh the rotation vector");
}

}  // namespace
}  // namespace mapjoin
