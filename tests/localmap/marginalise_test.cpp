// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/localmap/marginalise.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::Random;

template <typename D>
class MarginaliseTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Makes a map from pose 0 of poses 1 and 2 and of features 0 to 4, with a dense information matrix.
  void SetUp() override {
    map.poses = {1, 2};
    map.pose_estimates = {random.pose<kDim>(), random.pose<kDim>()};
    for (FeatureIndex f = 0; f < 5; ++f) {
      map.features.push_back(f);
      map.feature_estimates.push_back(random.vector<kDim>(4.0));
    }
    const Eigen::Index n = 2 * kPoseDof<kDim> + 5 * kDim;
    Eigen::MatrixXd A(n, n);
    for (auto& entry : A.reshaped()) entry = random.uniform(-1.0, 1.0);
    map.information = A * A.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
    map.information.template triangularView<Eigen::StrictlyLower>() = map.information.transpose();
    state = {{random.pose<kDim>(), random.pose<kDim>(), random.pose<kDim>()}, {}};
    for (int f = 0; f < 5; ++f) state.features.push_back(random.vector<kDim>(4.0));
  }
  static double chi2(const LocalMap<kDim>& map, const Values<kDim>& state) {
    Eigen::VectorXd r(map.information.rows());
    Eigen::Index row = 0;
    const auto add = [&](const Eigen::VectorXd& part) {
      r.segment(row, part.size()) = part;
      row += part.size();
    };
    for (std::size_t p = 0; p < map.poses.size(); ++p) {
      add(testing::plain_residual<kDim>(map.pose_estimates[p], state.pose(map.base), state.pose(map.poses[p])));
    }
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      add(testing::plain_residual<kDim>(map.feature_estimates[f], state.pose(map.base), state.features[map.features[f]]));
    }
    return r.dot(map.information * r);
  }

  Random random;
  LocalMap<kDim> map;
  Values<kDim> state;
  Table<FeatureIndex, bool> is_local{false, true, false, true, true};
};
TYPED_TEST_SUITE(MarginaliseTest, testing::Dimensions);

TYPED_TEST(MarginaliseTest, LeavesTheMarginalOfWhatStays) {
  constexpr int kDim = TestFixture::kDim;
  const auto marginalised = marginalise(this->map, this->is_local);
  EXPECT_EQ(marginalised.map.features, (std::vector<FeatureIndex>{0, 2}));
  EXPECT_EQ(marginalised.local_features, (std::vector<FeatureIndex>{1, 3, 4}));
  // The covariance of the marginal is a block of the covariance of the whole map.
  const Eigen::MatrixXd P = this->map.information.inverse();
  std::vector<Eigen::Index> stay;
  for (Eigen::Index row = 0; row < 2 * kPoseDof<kDim> + kDim; ++row) stay.push_back(row);
  for (int i = 0; i < kDim; ++i) stay.push_back(2 * kPoseDof<kDim> + 2 * kDim + i);
  const Eigen::MatrixXd P_stay = P(stay, stay);
  EXPECT_LT((marginalised.map.information * P_stay - Eigen::MatrixXd::Identity(P_stay.rows(), P_stay.cols())).norm(), 1e-8);
}

TYPED_TEST(MarginaliseTest, TheRecoveredFeaturesGiveTheWholeMapTheChi2OfTheMarginalisedOne) {
  const auto marginalised = marginalise(this->map, this->is_local);
  auto state = this->state;
  recover_local_features(marginalised, state);
  const double whole = this->chi2(this->map, state);
  EXPECT_NEAR(whole, this->chi2(marginalised.map, state), 1e-9 * whole);
  for (int k = 0; k < 20; ++k) {
    auto elsewhere = state;
    for (const FeatureIndex f : marginalised.local_features) {
      elsewhere.features[f] += this->random.template vector<TestFixture::kDim>(0.01);
    }
    EXPECT_GT(this->chi2(this->map, elsewhere), whole);
  }
  EXPECT_EQ(state.features[0], this->state.features[0]);
  EXPECT_EQ(state.features[2], this->state.features[2]);
}

TYPED_TEST(MarginaliseTest, ChangesNothingWithoutLocalFeatures) {
  const auto marginalised = marginalise(this->map, Table<FeatureIndex, bool>(5, false));
  EXPECT_EQ(marginalised.map.features, this->map.features);
  EXPECT_EQ(marginalised.map.information, this->map.information);
  EXPECT_TRUE(marginalised.local_features.empty());
}

TYPED_TEST(MarginaliseTest, AFeatureWhoseOwnInformationIsSingularStays) {
  constexpr int kDim = TestFixture::kDim;
  const Eigen::Index row = 2 * kPoseDof<kDim> + kDim;  // the first row of feature 1
  this->map.information.row(row).setZero();
  this->map.information.col(row).setZero();
  const auto marginalised = marginalise(this->map, this->is_local);
  EXPECT_EQ(std::count(marginalised.map.features.begin(), marginalised.map.features.end(), FeatureIndex(1)), 1);
}

TYPED_TEST(MarginaliseTest, LocalIsWhatOneMapAloneReferences) {
  LocalMap<TestFixture::kDim> other;
  other.features = {2, 4};
  const Table<FeatureIndex, bool> referenced{true, false, false, false, false};
  EXPECT_EQ(local_features<TestFixture::kDim>({this->map, other}, referenced),
            (std::vector<bool>{false, true, false, true, false}));
}

TYPED_TEST(MarginaliseTest, CanBeUndone) {
  const auto whole = restored(marginalise(this->map, this->is_local));
  EXPECT_EQ(whole.features, (std::vector<FeatureIndex>{0, 2, 1, 3, 4}));
  EXPECT_EQ(whole.information.rows(), this->map.information.rows());
  const double expected = this->chi2(this->map, this->state);
  EXPECT_NEAR(this->chi2(whole, this->state), expected, 1e-10 * expected);
}

}  // namespace
}  // namespace mapjoin
