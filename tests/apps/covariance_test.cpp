// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/apps/command.hpp>
#include <tests/support/dense_information.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

Eigen::MatrixXd matrix_of(const nlohmann::json& rows) {
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows.size(); ++j) {
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i].at(j).get<double>();
    }
  }
  return matrix;
}

template <typename D>
class CovarianceCommand : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;

  CovarianceCommand() {
    EXPECT_TRUE(write_g2o(log, folder.path() / "log.g2o"));
    RunOptions options;
    const auto solved = solve(log, options);
    state = {solved->map.poses, solved->map.features};
    DenseInformation<kDim> dense(state);
    for (const auto& o : log.graph.pose_factors) dense.add(o);
    for (const auto& o : log.graph.feature_factors) dense.add(o);
    inverse = dense.inverse({0});
    first_feature = dense.feature_row(0);
  }

  TemporaryFolder folder;
  Log<kDim> log = small_world<kDim>({.poses = 30, .features = 20, .closures = 2, .range = 2.5}).log;
  Values<kDim> state;
  Eigen::MatrixXd inverse;
  Eigen::Index first_feature = 0;
};
TYPED_TEST_SUITE(CovarianceCommand, Dimensions);

TYPED_TEST(CovarianceCommand, APoseIsCertainRelativeToItself) {
  const Ended ended = call({"covariance", this->folder.path() / "log.g2o", "7", "7"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.out, ::testing::Not(HasSubstr("nan")));
  const auto report = report_of({"covariance", (this->folder.path() / "log.g2o").string(), "7", "7"});
  EXPECT_TRUE(matrix_of(report["relations"].at(0)["covariance"]).isZero(0.0));
}

TYPED_TEST(CovarianceCommand, GivesBlocksOfTheDenseInverse) {
  constexpr int kDof = TestFixture::kDof;
  constexpr int kDim = TestFixture::kDim;
  const auto written = std::get<Log<kDim>>(open_log(this->folder.path() / "log.g2o").value());
  const std::string feature = key_text(written.features[3].key);  // its id in the file, which differs from those of poses
  const auto report =
      report_of({"covariance", (this->folder.path() / "log.g2o").string(), "pose:9", "feature:" + feature, "pose:0"});
  std::vector<Eigen::Index> rows;
  for (int i = 0; i < kDof; ++i) rows.push_back(9 * kDof + i);
  for (int i = 0; i < kDim; ++i) rows.push_back(this->first_feature + 3 * kDim + i);
  for (int i = 0; i < kDof; ++i) rows.push_back(i);
  const Eigen::MatrixXd expected = this->inverse(rows, rows);
  EXPECT_LT((matrix_of(report["covariance"]) - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
  EXPECT_EQ(report["variables"][0]["pose"], 9);
  EXPECT_EQ(report["variables"][1]["coordinates"].size(), std::size_t{kDim});
  EXPECT_EQ(report["gauge"]["held_poses"][0]["pose"], 0);
}

/// Each pair with a pose in it has a relation, in whatever order they are named: a feature in the frame of a pose, and the
/// later pose in that of the earlier one.
TYPED_TEST(CovarianceCommand, GivesRelativeCovariances) {
  constexpr int kDof = TestFixture::kDof;
  constexpr int kDim = TestFixture::kDim;
  const auto log = std::get<Log<kDim>>(open_log(this->folder.path() / "log.g2o").value());
  const auto report = report_of({"covariance", (this->folder.path() / "log.g2o").string(),
                                 "feature:" + key_text(log.features[3].key), "pose:9", "pose:17"});
  const auto expect = [&](const nlohmann::json& relation, int base, Eigen::Index target_row, Eigen::Index target_size,
                          auto&& seen) {
    const Pose<kDim> from = this->state.poses[PoseIndex(base)];
    const auto moved = [&](const Eigen::VectorXd& step) {
      return seen(retract(from, PoseVector<kDim>(step.head<kDof>())), step.tail(target_size));
    };
    const auto J = numerical_jacobian(moved, static_cast<int>(kDof + target_size));
    std::vector<Eigen::Index> rows;
    for (int i = 0; i < kDof; ++i) rows.push_back(base * kDof + i);
    for (Eigen::Index i = 0; i < target_size; ++i) rows.push_back(target_row + i);
    const Eigen::MatrixXd expected = J * this->inverse(rows, rows) * J.transpose();
    EXPECT_LT((matrix_of(relation["covariance"]) - expected).cwiseAbs().maxCoeff(), 1e-6 * expected.cwiseAbs().maxCoeff());
    EXPECT_EQ(relation["from"]["pose"], base);
    EXPECT_EQ(relation["position"].size(), std::size_t{kDim});
  };
  const Point<kDim> feature = this->state.features[3];
  const auto feature_seen = [&](const Pose<kDim>& from, const Eigen::VectorXd& step) {
    return Eigen::VectorXd(transform_into<kDim>(from, feature + step.head<kDim>()));
  };
  const Pose<kDim> target = this->state.poses[17];
  const Pose<kDim> relative = between(this->state.poses[9], target);
  const auto pose_seen = [&](const Pose<kDim>& from, const Eigen::VectorXd& step) {
    return Eigen::VectorXd(local(relative, between(from, retract(target, PoseVector<kDim>(step.head<kDof>())))));
  };
  ASSERT_EQ(report["relations"].size(), 3U);
  expect(report["relations"][0], 9, this->first_feature + 3 * kDim, kDim, feature_seen);
  expect(report["relations"][1], 17, this->first_feature + 3 * kDim, kDim, feature_seen);
  expect(report["relations"][2], 9, 17 * kDof, kDof, pose_seen);
}

TYPED_TEST(CovarianceCommand, SolvesTheFolderOfARunAndAStoreAgain) {
  const std::string log = (this->folder.path() / "log.g2o").string();
  const std::string out = (this->folder.path() / "out").string();
  const std::string store = (this->folder.path() / "log.maps").string();
  ASSERT_EQ(call({"run", log, "-o", out}).exit_code, 0);
  ASSERT_EQ(call({"build", log, "-o", store}).exit_code, 0);
  const Eigen::MatrixXd expected = matrix_of(report_of({"covariance", log, "pose:9", "pose:17"})["covariance"]);
  for (const std::string& input : {out, store}) {
    const Eigen::MatrixXd again = matrix_of(report_of({"covariance", input, "pose:9", "pose:17"})["covariance"]);
    EXPECT_LT((again - expected).cwiseAbs().maxCoeff(), 1e-6 * expected.cwiseAbs().maxCoeff()) << input;
  }
}

class CovarianceNames : public ::testing::Test {
 protected:
  Ended of(std::vector<std::string> names) {
    names.insert(names.begin(), {"covariance", log});
    return call(names);
  }
  TemporaryFolder folder;
  std::string log = folder.file("log.g2o", kSmallLog + "EDGE_SE2_XY 0 1 2 1 1 0 1\nEDGE_SE2_XY 2 1 0 1.1 1 0 1\n").string();
};

TEST_F(CovarianceNames, PoseAndFeatureOfOneNameAreToldApart) {
  const Ended both = of({"1"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.err, HasSubstr("\"1\" could be pose:0:1 or feature:1"));
  EXPECT_THAT(of({"pose:1", "feature:1", "0:2"}).out, HasSubstr("feature 1 from pose 1: "));
}

TEST_F(CovarianceNames, OfTheFolderOfARunAreThoseOfItsLog) {
  const std::string run = (folder.path() / "run").string();
  const std::string log = folder.file("met.g2o", "EDGE_SE2 0 7 1 0 0 1 0 0 1 0 1\nEDGE_SE2_XY 7 7 1 1 1 0 1\n").string();
  ASSERT_EQ(call({"run", log, "-o", run, "--quiet"}).exit_code, 0);
  ASSERT_THAT(content_of(run + "/map.g2o"), HasSubstr("VERTEX_XY 17 "));
  EXPECT_EQ(report_of({"covariance", run, "feature:7"})["variables"][0]["feature"], 7);
  EXPECT_THAT(call({"info", run}).out, ::testing::ContainsRegex("features +1, feature 7 to feature 7\n"));
}

TEST_F(CovarianceNames, WhatIsNotThereIsSaid) {
  EXPECT_THAT(of({"99"}).err, HasSubstr("\"99\" is none of the poses and features; `mapjoin info`"));
  EXPECT_THAT(of({"3:2"}).err, HasSubstr("\"3:2\" is none of"));
  EXPECT_THAT(of({"x!"}).err, HasSubstr("\"x!\" names no pose and no feature"));
}

TEST_F(CovarianceNames, SymbolsNamePoses) {
  const std::string a = std::to_string((std::uint64_t{'a'} << 56) + 1);
  const std::string b = std::to_string((std::uint64_t{'a'} << 56) + 2);
  const auto symbols = folder.file("symbols.g2o", "EDGE_SE2 " + a + " " + b + " 1 0 0 4 0 0 1 0 1\n").string();
  EXPECT_THAT(call({"covariance", symbols, "a2"}).out, HasSubstr("pose a2: standard deviations 0.5 1 m, 1 rad"));
}

TEST_F(CovarianceNames, CsvHasALineACoordinate) {
  const auto csv = folder.path() / "joint.csv";
  ASSERT_EQ(call({"covariance", log, "2", "7", "-o", csv.string()}).exit_code, 0);
  EXPECT_THAT(bytes_of(csv),
              ::testing::StartsWith("covariance,pose 2 x,pose 2 y,pose 2 phi,feature 7 x,feature 7 y\npose 2 x,"));
}

}  // namespace
}  // namespace mapjoin::testing
