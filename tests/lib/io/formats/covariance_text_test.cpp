// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/formats/covariance_text.hpp>
#include <string>
#include <tests/support/error_of.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
const Matrix<3> kCovariance = (Matrix<3>() << 4, 1, 0.5, 1, 3, 0.25, 0.5, 0.25, 2).finished();

Log<2> read_covariances(const std::string& text) {
  auto log = read_covariance_text(TextScanner("some.txt", text), {});
  if (log) return std::get<Log<2>>(*std::move(log));
  ADD_FAILURE() << log.error().message;
  return {};
}

std::string covariance_error(const std::string& text) {
  return testing::error_of(read_covariance_text(TextScanner("some.txt", text), {}));
}

TEST(OdomObs, ReadsBothFormsOfObservationsAndCountsTheUnassociated) {
  const auto log = read_covariances(
      "# header\n"
      "ODOM 0 1 0.1 0.2 0.3 4 1 0.5 3 0.25 2\n"
      "OBS 0 17 1 2 2 1 3\n"
      "OBS 1 17 3 4 0.9 2 1 3\n"
      "OBS 1 -1 3 4 0.9 0 0 0\n");
  EXPECT_TRUE((log.odometry()[0].information * kCovariance).isIdentity(1e-14));
  EXPECT_EQ(log.odometry()[0].measured.translation, Point<2>(0.1, 0.2));
  EXPECT_EQ(log.odometry()[0].measured.rotation.angle(), 0.3);
  ASSERT_EQ(log.observations().size(), 2u);
  EXPECT_EQ(log.observations()[1].measured, Point<2>(3, 4));
  const Matrix<2> P = (Matrix<2>() << 2, 1, 1, 3).finished();
  for (const auto& o : log.observations()) EXPECT_TRUE((o.information * P).isIdentity(1e-14));
  EXPECT_THAT(log.features, ElementsAre(FeatureId{17}));
  EXPECT_EQ(log.unassociated, 1);
}

TEST(MapCircles, CountsPosesByStepsAndOrdersTheCovariance) {
  const auto log = read_covariances(
      "STEP image.0000 0.1 0.2 0.3 4 1 3 0.5 0.25 2\n"
      "LANDMARK_C 1 2 0.9 2 1 3 23\n"
      "STEP image.0001 0.1 0.2 0.3 4 1 3 0.5 0.25 2\n"
      "LANDMARK_C 1 2 0.9 0 0 0 -1\n"
      "LANDMARK_C 3 4 0.9 2 1 3 7\n");
  EXPECT_THAT(log.poses, ElementsAre(PoseId{0, 0}, PoseId{0, 1}, PoseId{0, 2}));
  EXPECT_TRUE((log.odometry()[1].information * kCovariance).isIdentity(1e-14));
  EXPECT_EQ(log.observations()[0].base, PoseIndex(1));
  EXPECT_EQ(log.observations()[1].base, PoseIndex(2));
  EXPECT_THAT(log.features, ElementsAre(FeatureId{7}, FeatureId{23}));
  EXPECT_EQ(log.unassociated, 1);
}

TEST(CovarianceText, NamesLineAndColumnOfWhatIsWrong) {
  EXPECT_EQ(covariance_error("OBS 0 17 1 2 1 2 1\n"),
            "some.txt:1:18: the covariance that ends here is not positive definite; --repair-information takes the nearest one "
            "that is, where variances are positive");
  EXPECT_EQ(covariance_error("OBS 0 17 1 2 1 0 1\nOBS 0 -1 1 2 1 2 1\n"), "") << "what is left out needs no covariance";
  EXPECT_EQ(covariance_error("OBS 0 -2 1 2 1 0 1\n"), "some.txt:1:7: a feature has the id -2");
  EXPECT_EQ(covariance_error("OBS 0 2 1 2 1 0\n"), "some.txt:1:16: the line ends where a number is expected");
  EXPECT_EQ(covariance_error("OBS 0 2 1 2 0.9 1 0 1 5\n"), "some.txt:1:23: '5' stands where the line should end");
  EXPECT_EQ(covariance_error("OBS 0 2 1 2 1 0 1\nSTEP 0 1"),
            "some.txt:2:1: unknown tag 'STEP'; --skip-unknown leaves such lines out");
  EXPECT_EQ(covariance_error("LANDMARK_C 1 2 0.9 2 1 3 7 8\n"), "some.txt:1:28: '8' stands where the line should end");
  EXPECT_EQ(covariance_error("LANDMARK_C 1 2 0.9 2 1 3 7\nODOM 0 1"), "some.txt:2:1: unknown tag 'ODOM'");
}

TEST(CovarianceText, RepairsACovarianceThatIsNotDefiniteAndCountsIt) {
  const auto log = read_covariance_text(TextScanner("some.txt", "OBS 0 17 1 2 1 2 1\n"), {.repair_information = true});
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_EQ(std::get<Log<2>>(*log).conventions.repairs.indefinite, 1);
}

}  // namespace
}  // namespace mapjoin
