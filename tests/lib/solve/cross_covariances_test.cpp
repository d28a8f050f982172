// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/solve/cross_covariances.hpp>
#include <tests/lib/solve/rings_fixture.hpp>

namespace mapjoin {
namespace {

class CrossCovariancesTest : public testing::RingsTest {};

TEST_P(CrossCovariancesTest, AreTheBlocksOfTheDenseInverse) {
  ASSERT_FALSE(equations.factorise(0.0));
  const CrossCovariances cross(equations);
  std::vector<Variable> all;
  for (const Variable v : equations.variables()) all.push_back(v);
  all.push_back(all.front());  // a variable may be asked for more than once
  for (const std::vector<Variable>& rows : {std::vector<Variable>{0}, {Variable(count - 1), Variable(count / 2)}}) {
    const Eigen::MatrixXd of_all = inverse(entries(rows), entries(all));
    EXPECT_LT((cross.between(rows, all) - of_all).norm(), 1e-12 * of_all.norm());
    const double tolerance = 1e-12 * inverse_over(rows).norm();
    for (const Variable v : all) {
      const Eigen::MatrixXd expected = inverse(entries(rows), entries({v}));
      EXPECT_LT((cross.between(rows, {&v, 1}) - expected).norm(), tolerance) << rows.front().value << " and " << v.value;
    }
  }
}

TEST_P(CrossCovariancesTest, GiveTheJointOneOfAnyVariables) {
  ASSERT_FALSE(equations.factorise(0.0));
  const CrossCovariances cross(equations);
  std::vector<Variable> all;
  for (const Variable v : equations.variables()) all.insert(all.begin(), v);
  for (const std::vector<Variable>& variables : {std::vector<Variable>{}, {Variable(count - 1), 0, 0}, all}) {
    const Eigen::MatrixXd expected = inverse_over(variables);
    const Eigen::MatrixXd joint = cross.joint(variables);
    ASSERT_EQ(joint.rows(), expected.rows());
    EXPECT_LE((joint - expected).norm(), 1e-12 * expected.norm());
    EXPECT_EQ(joint, joint.transpose());
  }
}

TEST_P(CrossCovariancesTest, SolveForVariablesOfARightHandSideThatIsZeroElsewhere) {
  ASSERT_FALSE(equations.factorise(0.0));
  const CrossCovariances cross(equations);
  for (const std::vector<Variable>& variables : {std::vector<Variable>{0}, {Variable(count - 1), 0, Variable(count / 2)}}) {
    const Eigen::MatrixXd covariance = inverse_over(variables);
    const Eigen::MatrixXd b = Eigen::MatrixXd::Random(covariance.cols(), 3);
    const Eigen::MatrixXd expected = covariance * b;
    EXPECT_LT((cross.solved(variables, b) - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST_P(CrossCovariancesTest, CountTheirMemoryBeforehand) {
  ASSERT_FALSE(equations.factorise(0.0));
  const CrossCovariances cross(equations);
  std::vector<Variable> all;
  for (const Variable v : equations.variables()) all.push_back(v);
  const std::int64_t of_result = 8 * equations.size() * equations.size();
  EXPECT_GT(cross.bytes(all), of_result + equations.factor_bytes() / equations.size());
  EXPECT_LT(cross.bytes(all), 40 * of_result);
  EXPECT_LT(cross.bytes({all.data(), 1}), cross.bytes(all));
  EXPECT_LT(cross.bytes({}), 100);
}

INSTANTIATE_TEST_SUITE_P(Variables, CrossCovariancesTest, testing::kRings, testing::name_of_rings);

}  // namespace
}  // namespace mapjoin
