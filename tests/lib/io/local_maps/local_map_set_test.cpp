// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <Eigen/LU>
#include <mapjoin/geometry/euler.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/random.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Random;

struct Row {
  std::int64_t id;
  double value;
};

/// The text of map `number` in the format of Linear SLAM.
std::string text_map(int number, const std::vector<Row>& state, const Eigen::MatrixXd& information) {
  std::string text = fmt::format("{}\n{}\n", number - 1, state.size());
  for (const Row& row : state) text += fmt::format("{} {}\n", row.id, row.value);
  for (Eigen::Index i = 0; i < information.rows(); ++i) {
    for (Eigen::Index j = 0; j < information.cols(); ++j) text += fmt::format("{} ", information(i, j));
    text += "\n";
  }
  return text;
}

/// Writes a map as a MAT file in the authors' format.
void write_mat_map(const fs::path& path, const std::vector<Row>& state, Eigen::MatrixXd covariance) {
  const std::size_t n = state.size();
  Eigen::MatrixXd rows(n, 2);
  for (std::size_t i = 0; i < n; ++i) {
    rows.row(static_cast<Eigen::Index>(i)) << static_cast<double>(state[i].id), state[i].value;
  }
  mat_t* mat = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  std::size_t state_size[2] = {n, 2};
  std::size_t covariance_size[2] = {n, n};
  for (matvar_t* variable :
       {Mat_VarCreate("localmap_st", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, state_size, rows.data(), 0),
        Mat_VarCreate("localmap_P", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, covariance_size, covariance.data(), 0)}) {
    Mat_VarWrite(mat, variable, MAT_COMPRESSION_ZLIB);
    Mat_VarFree(variable);
  }
  Mat_Close(mat);
}

class LocalMapSetTest : public ::testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder.path() / name; }
  std::string error() const {
    const auto set = read_local_map_set(folder.path());
    return set ? "no error" : set.error().message;
  }
  template <int Dim>
  SubmapSet<Dim> read() const {
    auto set = read_local_map_set(folder.path());
    EXPECT_TRUE(set) << set.error().message;
    return std::get<SubmapSet<Dim>>(*set);
  }
  testing::TemporaryFolder folder;
  Random random;
  const std::vector<Row> plane{{0, 1.0}, {0, 2.0}, {0, 7.5}, {40, -3.0}, {40, 4.0}, {9, 5.0}, {9, 6.0}};
};

TEST_F(LocalMapSetTest, PutsMapsInTheOrderOfTheirNumbersAndGzippedOnesAmongThem) {
  for (int number = 2; number <= 10; ++number) {
    folder.file(fmt::format("localmap_{}.txt", number),
                text_map(number, {{-number, 0.1 * number}, {-number, 0}, {-number, 0}}, Matrix<3>::Identity()));
  }
  testing::write_gzip(path("localmap_1.txt.gz"), text_map(1, plane, random.information<7>()));
  folder.file("notes.txt", "not a map");

  const auto set = read<2>();
  ASSERT_EQ(set.graph.submaps.size(), 10u);
  ASSERT_EQ(set.poses.size(), 11u);
  for (const PoseIndex p : indices(set.poses)) EXPECT_EQ(set.poses[p], (PoseId{0, p.position()}));
  for (PoseIndex end = 1; end <= 10; ++end) {
    const auto& map = set.graph.submaps[(end - 1).position()];
    EXPECT_EQ(map.base, end - 1);
    EXPECT_THAT(map.poses, ElementsAre(end));
    EXPECT_EQ(set.segments[(end - 1).position()], (Segment{end - 1, end, true}));
    EXPECT_DOUBLE_EQ(map.pose_estimates[0].translation.x(), end == 1 ? 1.0 : 0.1 * end.value);
  }
  EXPECT_THAT(set.features, ElementsAre(FeatureId{9}, FeatureId{40}));
  EXPECT_EQ(set.graph.submaps[0].features, (std::vector<FeatureIndex>{1, 0}));
  EXPECT_EQ(set.graph.submaps[0].feature_estimates[1], Point<2>(5.0, 6.0));
  EXPECT_EQ(set.graph.submaps[0].pose_estimates[0].rotation.angle(), 7.5);
}

TEST_F(LocalMapSetTest, CountsMapsFromOne) {
  folder.file("localmap_0.txt", text_map(0, plane, random.information<7>()));
  EXPECT_THAT(error(), HasSubstr("localmap_0.txt: local maps are counted from 1"));
}

TEST_F(LocalMapSetTest, TellsFeatureZeroFromTheEndPose) {
  write_mat_map(path("localmap_1.mat"), {{0, 1.0}, {0, 2.0}, {0, 7.5}, {0, -3.0}, {0, 4.0}}, Matrix<5>::Identity());
  EXPECT_THAT(read<2>().features, ElementsAre(FeatureId{0}));
  const std::vector<Row> space(9, Row{0, 0.5});
  write_mat_map(path("localmap_1.mat"), space, Matrix<9>::Identity());
  EXPECT_THAT(read<3>().features, ElementsAre(FeatureId{0}));
}

TEST_F(LocalMapSetTest, RefusesAnIdThatNoDoubleTellsFromAnother) {
  const std::int64_t end = std::int64_t{1} << 53;
  for (const std::int64_t id : {end - 1, end, end + 1}) {
    folder.file("localmap_1.txt", text_map(1, {{0, 1.0}, {0, 2.0}, {0, 7.5}, {id, -3.0}, {id, 4.0}}, Matrix<5>::Identity()));
    EXPECT_THAT(error(), id < end ? HasSubstr("no error") : HasSubstr("localmap_1.txt:6:1: an id must be below 2^53"));
  }
}

TEST_F(LocalMapSetTest, TheInformationOfAMatMapIsTheInverseOfItsCovariance) {
  const Matrix<7> P = random.information<7>();
  write_mat_map(path("localmap_1.mat"), plane, P);
  const auto set = read<2>();
  EXPECT_LT((set.graph.submaps[0].information * P - Matrix<7>::Identity()).norm(), 1e-12);
  EXPECT_EQ(set.graph.submaps[0].information, set.graph.submaps[0].information.transpose());
}

TEST_F(LocalMapSetTest, AnExactCoincidenceIsOnePose) {
  std::vector<Row> still = plane;
  for (int i = 0; i < 3; ++i) still[static_cast<std::size_t>(i)].value = 0.0;
  Matrix<7> P = Matrix<7>::Zero();
  P.bottomRightCorner<4, 4>() = random.information<4>();
  write_mat_map(path("localmap_1.mat"), plane, random.information<7>());
  write_mat_map(path("localmap_2.mat"), still, P);
  write_mat_map(path("localmap_3.mat"), plane, random.information<7>());

  const auto set = read<2>();
  EXPECT_THAT(set.poses, ElementsAre(PoseId{0, 0}, PoseId{0, 1}, PoseId{0, 3}));
  EXPECT_EQ(set.graph.submaps[1].base, PoseIndex(1));
  EXPECT_THAT(set.graph.submaps[1].poses, IsEmpty());
  EXPECT_EQ(set.graph.submaps[1].information.rows(), 4);
  EXPECT_EQ(set.graph.submaps[2].base, PoseIndex(1));
  EXPECT_EQ(set.graph.submaps[2].poses, std::vector{PoseIndex(2)});
  EXPECT_THAT(set.segments, ElementsAre(Segment{0, 1}, Segment{1, 1}, Segment{1, 2}));
}

TEST_F(LocalMapSetTest, AZeroCovarianceWithMotionIsNotPositiveDefinite) {
  write_mat_map(path("localmap_1.mat"), {{0, 1.0}, {0, 0.0}, {0, 0.0}}, Matrix<3>::Zero());
  EXPECT_THAT(error(), HasSubstr("localmap_1.mat: the covariance of map 1 is not positive definite"));
}

/// A state of an end pose x y z a b c and one feature.
std::vector<Row> space(std::int64_t id, const Vector<9>& x) {
  std::vector<Row> state;
  for (int i = 0; i < 9; ++i) state.push_back({i < 6 ? id : 12, x[i]});
  return state;
}

TEST_F(LocalMapSetTest, TheGaussianOverEulerAnglesIsTurnedToTheRotationVector) {
  const Vector<9> x = random.vector<9>(1.2);
  const Matrix<9> W = random.information<9>();
  folder.file("localmap_1.txt", text_map(1, space(-1, x), W));
  write_mat_map(path("localmap_2.mat"), space(0, x), W.inverse());

  const auto set = read<3>();
  const Pose<3>& end = set.graph.submaps[0].pose_estimates[0];
  const Matrix<3> R = (Eigen::AngleAxisd(x[3], Vector<3>::UnitZ()) * Eigen::AngleAxisd(x[4], Vector<3>::UnitY()) *
                       Eigen::AngleAxisd(x[5], Vector<3>::UnitX()))
                          .toRotationMatrix();
  EXPECT_LT((end.rotation.matrix() - R).norm(), 1e-14);
  EXPECT_LT((set.graph.submaps[0].information - set.graph.submaps[1].information).norm(), 1e-12 * W.norm());
  // A small step of the file's state costs the same in both coordinates.
  for (int i = 0; i < 20; ++i) {
    const Vector<9> d = random.vector<9>(1e-6);
    Vector<9> step = d;
    step.segment<3>(3) = (end.rotation.inverse() * rotation_from_euler(x[5] + d[5], x[4] + d[4], x[3] + d[3])).log();
    EXPECT_NEAR(step.dot(set.graph.submaps[0].information * step) / d.dot(W * d), 1.0, 1e-5);
  }
}

TEST_F(LocalMapSetTest, NamesTheMissingAndTheRepeatedNumber) {
  const std::string text = text_map(3, {{-3, 0}, {-3, 0}, {-3, 0}}, Matrix<3>::Identity());
  folder.file("localmap_3.txt", text);
  folder.file("localmap_1.txt", text_map(1, {{-1, 0}, {-1, 0}, {-1, 0}}, Matrix<3>::Identity()));
  EXPECT_THAT(error(), HasSubstr("map 2 is missing"));
  fs::remove(path("localmap_1.txt"));
  EXPECT_THAT(error(), HasSubstr("map 1 is missing"));
  testing::write_gzip(path("localmap_3.txt.gz"), text);
  fs::rename(path("localmap_3.txt"), path("localmap_3.mat"));
  EXPECT_THAT(error(), HasSubstr("map 1 is missing"));
  folder.file("localmap_1.txt", text_map(1, {{-1, 0}, {-1, 0}, {-1, 0}}, Matrix<3>::Identity()));
  folder.file("localmap_2.txt", text_map(2, {{-2, 0}, {-2, 0}, {-2, 0}}, Matrix<3>::Identity()));
  EXPECT_THAT(error(), HasSubstr("map 3 is there twice"));
}

TEST_F(LocalMapSetTest, NamesTheRowOfAStateThatMakesNoSense) {
  const auto error_of = [&](std::vector<Row> state) {
    const auto n = static_cast<Eigen::Index>(state.size());
    write_mat_map(path("localmap_1.mat"), state, Eigen::MatrixXd::Identity(n, n));
    return error();
  };
  const std::vector<Row> pose{{0, 1.0}, {0, 2.0}, {0, 0.5}};
  const auto with = [&](std::vector<Row> rows) {
    rows.insert(rows.begin(), pose.begin(), pose.end());
    return rows;
  };
  EXPECT_THAT(error_of({}), HasSubstr("begins with 0 rows of one id"));
  EXPECT_THAT(error_of({{0, 1.0}, {0, 1.0}}), HasSubstr("begins with 2 rows of one id; an end pose has 3 or 6"));
  EXPECT_THAT(error_of({{5, 1.0}, {5, 1.0}, {5, 1.0}}), HasSubstr("row 1 of the state: the end pose's id is 5, not 0 or -1"));
  EXPECT_THAT(error_of(with({{7, 1.0}})), HasSubstr("row 4 of the state: feature 7 has 1 rows, not 2"));
  EXPECT_THAT(error_of(with({{7, 1.0}, {8, 1.0}})), HasSubstr("row 4 of the state: feature 7 has 1 rows, not 2"));
  EXPECT_THAT(error_of(with({{-7, 1.0}, {-7, 1.0}})), HasSubstr("row 4 of the state: -7 is not a feature's id"));
  EXPECT_THAT(error_of(with({{7, 1.0}, {7, 1.0}, {8, 1.0}, {8, 1.0}, {7, 1.0}, {7, 1.0}})),
              HasSubstr("row 8 of the state: feature 7 is there for the second time"));
  EXPECT_THAT(error_of(with({{7, 1.0}, {7, std::nan("")}})), HasSubstr("row 5 of the state: the value is not finite"));
}

TEST_F(LocalMapSetTest, RefusesGaussiansThatAreNone) {
  Matrix<7> P = random.information<7>();
  const auto error_of = [&](const Eigen::MatrixXd& covariance) {
    write_mat_map(path("localmap_1.mat"), plane, covariance);
    return error();
  };
  P(2, 5) += 0.1;
  EXPECT_THAT(error_of(P), HasSubstr("the covariance of map 1 is not symmetric"));
  EXPECT_THAT(error(), HasSubstr("; --repair-information takes its symmetric part"));
  P(2, 5) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(error_of(P), HasSubstr("the covariance of map 1 is not finite"));
  EXPECT_THAT(error_of(-Matrix<7>::Identity()), HasSubstr("is not positive definite"));

  fs::remove(path("localmap_1.mat"));
  Matrix<3> W = Matrix<3>::Identity();
  W(0, 0) = -1.0;
  folder.file("localmap_1.txt", text_map(1, {{-1, 0}, {-1, 0}, {-1, 0}}, W));
  EXPECT_THAT(error(), HasSubstr("the information matrix of map 1 is indefinite"));
  const auto repaired = read_local_map_set(folder.path(), {.repair_information = true});
  ASSERT_TRUE(repaired);
  EXPECT_EQ(std::get<SubmapSet<2>>(*repaired).conventions.repairs.indefinite, 1);
}

TEST_F(LocalMapSetTest, TakesTheAsymmetryThatAFilterLeavesAndCountsIt) {
  Matrix<7> P = random.information<7>();
  P(2, 5) += 1.3e-8 * P.cwiseAbs().maxCoeff();
  write_mat_map(path("localmap_1.mat"), plane, P);
  const auto read = read_local_map_set(folder.path(), {});
  ASSERT_TRUE(read) << read.error().message;
  const auto& set = std::get<SubmapSet<2>>(*read);
  EXPECT_EQ(set.conventions.repairs.symmetrised, 1);
  EXPECT_NEAR(set.conventions.repairs.largest_asymmetry, 1.3e-8, 1e-10);
  EXPECT_EQ(set.graph.submaps[0].information, set.graph.submaps[0].information.transpose());
}

TEST_F(LocalMapSetTest, NamesLineAndColumnOfAMalformedText) {
  const std::string good = text_map(1, {{-1, 1}, {-1, 2}, {-1, 3}}, Matrix<3>::Identity());
  const auto error_of = [&](const std::string& text) {
    folder.file("localmap_1.txt", text);
    return error();
  };
  ASSERT_EQ(error_of(good), "no error");
  EXPECT_THAT(error_of("0\n3\n-1 1\n-1 x2\n" + std::string(40, ' ')), HasSubstr("localmap_1.txt:4:4: 'x2' stands where"));
  EXPECT_THAT(error_of(good + "1"), HasSubstr("localmap_1.txt:9:"));
  EXPECT_THAT(error_of(good.substr(0, good.size() - 7)), HasSubstr("localmap_1.txt:8:"));
  EXPECT_THAT(error_of(good.substr(0, good.size() - 3)), HasSubstr("localmap_1.txt:8:5: the line ends where a number"));
  EXPECT_THAT(error_of("4\n" + good.substr(2)), HasSubstr("localmap_1.txt:1:1: by the file's name the start pose is 0"));
  for (const char* count : {"1000", "6000000000", "18446744073709551615"}) {
    EXPECT_THAT(error_of(fmt::format("0\n{}\n-1 1\n", count)), HasSubstr("localmap_1.txt:2:1: the file is too short")) << count;
  }
  EXPECT_THAT(error_of("0\n-3\n"), HasSubstr("localmap_1.txt:2:1: '-3' stands where"));
}

TEST_F(LocalMapSetTest, RefusesAFolderWithoutMapsAndMapsOfBothDimensions) {
  EXPECT_THAT(error(), HasSubstr("holds no localmap_<k>.mat or localmap_<k>.txt"));
  folder.file("localmap_1.txt", text_map(1, {{-1, 0}, {-1, 0}, {-1, 0}}, Matrix<3>::Identity()));
  folder.file("localmap_2.txt", text_map(2, space(-2, Vector<9>::Zero()), Matrix<9>::Identity()));
  EXPECT_THAT(error(), HasSubstr("localmap_1.txt is a map of the plane, but"));
}

}  // namespace
}  // namespace mapjoin
