// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/io/open.hpp>
#include <tests/support/data.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using testing::data_file;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Log<2> read(const std::filesystem::path& path) {
  auto log = open_log(path);
  EXPECT_TRUE(log) << log.error().message;
  return std::get<Log<2>>(*log);
}

class MatLogTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const char* variable, Eigen::MatrixXd table) {
    const std::filesystem::path path = folder.path() / "log.mat";
    mat_t* mat = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
    std::size_t dims[2] = {static_cast<std::size_t>(table.rows()), static_cast<std::size_t>(table.cols())};
    matvar_t* matrix = Mat_VarCreate(variable, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, table.data(), 0);
    Mat_VarWrite(mat, matrix, MAT_COMPRESSION_ZLIB);
    Mat_VarFree(matrix);
    Mat_Close(mat);
    return path;
  }
  std::string error(const char* variable, const Eigen::MatrixXd& table) {
    const auto path = write(variable, table);
    const auto log = read_mat_log(testing::content_of(path), path.string());
    return log ? "no error" : log.error().message;
  }
  testing::TemporaryFolder folder;
};

TEST_F(MatLogTest, ReadsARowOfVictoriaParkInTheOrderOfItsColumns) {
  Eigen::MatrixXd table(2, 12);
  table << 1, 4, 5, 1.0, 2.0, 3.0, 4, 1, 2, 5, 3, 6,  //
      0, 4, 77, 10.0, 20.0, 2, 1, 3, 0, 0, 0, 0;
  const Log<2> log = read(write("VicPark_clean_data", table));
  EXPECT_THAT(log.poses, ElementsAre(PoseId{0, 4}, PoseId{0, 5}));
  EXPECT_THAT(log.features, ElementsAre(FeatureId{77}));
  ASSERT_EQ(log.odometry().size(), 1u);
  EXPECT_EQ(local(Pose<2>{}, log.odometry()[0].measured), Vector<3>(1, 2, 3));
  const Matrix<3> P = (Matrix<3>() << 4, 1, 2, 1, 5, 3, 2, 3, 6).finished();
  EXPECT_LT((log.odometry()[0].information * P - Matrix<3>::Identity()).norm(), 1e-14);
  ASSERT_EQ(log.observations().size(), 1u);
  EXPECT_EQ(log.observations()[0].base, PoseIndex(0));
  EXPECT_EQ(log.observations()[0].measured, Point<2>(10, 20));
  const Matrix<2> Q = (Matrix<2>() << 2, 1, 1, 3).finished();
  EXPECT_LT((log.observations()[0].information * Q - Matrix<2>::Identity()).norm(), 1e-14);
}

TEST_F(MatLogTest, ReadsDlrRowsAtThePoseThatTheStepLedTo) {
  Eigen::MatrixXd table(3, 10);
  table << -100, 1.0, 2.0, 3.0, 4, 1, 5, 2, 3, 6,  //
      10.0, 20.0, 0.5, 2, 1, 3, 77, 0, 0, 0,       //
      11.0, 21.0, 0.5, 2, 1, 3, -1, 0, 0, 0;
  const Log<2> log = read(write("corrected_data_circles", table));
  const Matrix<3> P = (Matrix<3>() << 4, 1, 2, 1, 5, 3, 2, 3, 6).finished();
  EXPECT_LT((log.odometry()[0].information * P - Matrix<3>::Identity()).norm(), 1e-14);
  ASSERT_EQ(log.observations().size(), 1u);
  EXPECT_EQ(log.observations()[0].base, PoseIndex(1));
  EXPECT_EQ(log.unassociated, 1);
}

TEST_F(MatLogTest, NamesVariableAndRowOfAFault) {
  Eigen::MatrixXd table(2, 12);
  table << 1, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 1,  //
      0, 0, 5, 1, 1, 1, 0, 1, 0, 0, 0, 0;
  ASSERT_EQ(error("VicPark_clean_data", table), "no error");
  const auto error_with = [&](Eigen::Index col, double value) {
    Eigen::MatrixXd changed = table;
    changed(1, col) = value;
    return error("VicPark_clean_data", changed);
  };
  EXPECT_THAT(error_with(0, 2.0), HasSubstr("log.mat: variable VicPark_clean_data, row 2: begins with 2"));
  EXPECT_THAT(error_with(2, 1.5), HasSubstr("row 2: column 3: 1.5 is not an id"));
  EXPECT_THAT(error_with(1, -3.0), HasSubstr("row 2: column 2: -3 is not an id"));
  EXPECT_THAT(error_with(2, 1e17), HasSubstr("row 2: column 3: 1e+17 is not an id"));
  EXPECT_THAT(error_with(7, -1.0), HasSubstr("row 2: the covariance is not positive definite"));
  EXPECT_THAT(error_with(3, std::nan("")), HasSubstr("row 2: a value is not finite"));
  EXPECT_THAT(error("VicPark_clean_data", table.leftCols(11)), HasSubstr("has 11 columns, not 12"));
  EXPECT_THAT(error("other", table), HasSubstr("holds neither the variable VicPark_clean_data nor"));
  EXPECT_THAT(error("poses", table), HasSubstr("log.mat: is a map for MATLAB and Octave, which is only written"));
}

TEST(MatLogData, VictoriaPark) {
  const Log<2> log = read(data_file("vicpark-6898/VicPark_clean_data.mat"));
  EXPECT_EQ(log.poses.size(), 6899u);
  EXPECT_EQ(log.features.size(), 299u);
  EXPECT_EQ(log.odometry().size(), 6898u);
  EXPECT_EQ(log.observations().size(), 45390u);
  EXPECT_EQ(log.sessions.size(), 1u);
  EXPECT_TRUE(log.closures().empty());
}

TEST(MatLogData, DlrCorrected) {
  const Log<2> log = read(data_file("dlr/corrected_data_circles.mat"));
  EXPECT_EQ(log.poses.size(), 3298u);
  EXPECT_EQ(log.features.size(), 549u);
  EXPECT_EQ(log.odometry().size(), 3297u);
  EXPECT_EQ(log.observations().size(), 14184u);
  EXPECT_EQ(log.unassociated, 436);
}

}  // namespace
}  // namespace mapjoin
