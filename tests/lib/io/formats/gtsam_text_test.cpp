// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <mapjoin/io/formats/covariance_text.hpp>
#include <mapjoin/io/open.hpp>
#include <string>
#include <tests/support/error_of.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string gtsam_error(const std::string& text) {
  return testing::error_of(read_edge_text(TextScanner("some.txt", text), kGtsamText, nullptr, {}));
}

const std::string kOdometry = "ODOMETRY 0 1 1 2 0.5 4 0 0 4 0 0.25\n";

TEST(GtsamText, HasCovariances) {
  const auto log = std::get<Log<2>>(
      read_edge_text(TextScanner("some.txt", kOdometry + "LANDMARK 1 2 3 4 0.5 0 2\n"), kGtsamText, nullptr, {}).value());
  EXPECT_TRUE(log.odometry()[0].information.isApprox(Matrix<3>(Vector<3>(0.25, 0.25, 4.0).asDiagonal()), 1e-15));
  EXPECT_THAT(log.features, ElementsAre(FeatureId{2}));
  EXPECT_EQ(log.observations()[0].base, PoseIndex(1));
  EXPECT_TRUE(log.observations()[0].information.isApprox(Matrix<2>(Vector<2>(2.0, 0.5).asDiagonal()), 1e-15));
}

TEST(GtsamText, IsToldFromIsamByItsOdometryWhereverItStands) {
  const testing::TemporaryFolder folder;
  const auto log = open_log(folder.file("log", "LANDMARK 1 2 3 4 0.5 0 2\n" + kOdometry));
  EXPECT_NEAR(std::get<Log<2>>(log.value()).observations()[0].information(0, 0), 2.0, 1e-15);
}

TEST(GtsamText, NumbersFeaturesApartFromPoses) {
  const testing::TemporaryFolder folder;
  const auto log = std::get<Log<2>>(
      read_edge_text(TextScanner("some.txt", kOdometry + "LANDMARK 1 1 3 4 0.25 0 4\n"), kGtsamText, nullptr, {}).value());
  ASSERT_TRUE(write_edge_text(log, kGtsamText, folder.path() / "out"));
  EXPECT_THAT(testing::content_of(folder.path() / "out"), HasSubstr("\nLANDMARK 1 11 3 4 0.25 0 4\n"));
}

TEST(GtsamText, NamesTheFirstEdgeThatItCannotSayThoughManyLinesAreFilledSideBySide) {
  const testing::TemporaryFolder folder;
  std::string text;
  for (int k = 0; k < 3000; ++k) text += fmt::format("ODOMETRY {} {} 1 2 0.5 4 0 0 4 0 0.25\n", k, k + 1);
  auto log = std::get<Log<2>>(read_edge_text(TextScanner("some.txt", text), kGtsamText, nullptr, {}).value());
  for (const std::size_t k : {2900u, 900u, 1700u}) log.graph.pose_factors[k].information.setZero();
  const auto written = write_edge_text(log, kGtsamText, folder.path() / "out");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().message,
            "some.txt: the edge from pose 900 to pose 901 has an information matrix that is singular, and so no covariance, "
            "which GTSAM's text files cannot say");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
}

TEST(GtsamText, NamesThePlaceOfWhatIsWrong) {
  EXPECT_EQ(gtsam_error("ODOMETRY 0 1 1 2 0.5 4 0 0 4 0 0\n"),
            "some.txt:1:32: the covariance that ends here is not positive definite; --repair-information takes the nearest one "
            "that is, "
            "where variances are positive");
  EXPECT_EQ(gtsam_error(kOdometry + "LANDMARK 1 2 3 4 0.5 0\n"), "some.txt:2:23: the line ends where a number is expected");
  EXPECT_EQ(gtsam_error(kOdometry + "BR 1 2 3 4 0.5 1\n"),
            "some.txt:2:1: unknown tag 'BR'; --skip-unknown leaves such lines out");
  EXPECT_EQ(gtsam_error(kOdometry + "LANDMARK 1 2 3 inf 0.5 0 1\n"), "some.txt:2:16: 'inf' stands where a number is expected");
}

}  // namespace
}  // namespace mapjoin
