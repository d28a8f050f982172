// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <mapjoin/join/association/alignment_branch.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <numeric>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>

namespace mapjoin {
namespace {

/// The estimate of local maps none of whose features are taken for the same, with the pairs that truly are.
template <int Dim>
struct Apart {
  FeatureEstimate<Dim> estimate;
  std::vector<FeaturePair> same;

  Apart() {
    ManhattanOptions options;
    options.poses = 60;
    const auto set = testing::small_submap_set(simulate_manhattan<Dim>(options).log, 10.0);
    std::map<FeatureIndex, FeatureIndex> first;
    std::int32_t next = 0;
    for (const auto& map : set.graph.submaps) {
      for (const FeatureIndex name : map.features) {
        const FeatureIndex own(next++);
        const auto [seen, is_first] = first.emplace(name, own);
        if (!is_first) same.push_back({seen->second, own});
      }
    }
    std::vector<std::size_t> labels(static_cast<std::size_t>(next));
    std::iota(labels.begin(), labels.end(), std::size_t{0});
    estimate = estimate_of(renamed(set, Identities(sightings_of(set), labels)), {}).value();
  }
};

template <typename D>
class AlignmentBranchTest : public ::testing::Test {};
TYPED_TEST_SUITE(AlignmentBranchTest, testing::Dimensions);

TYPED_TEST(AlignmentBranchTest, ExpectsFeaturesWhereTheDenseConditionalHasThem) {
  constexpr int kDim = TypeParam::value;
  const Apart<kDim> apart;
  ASSERT_GE(apart.same.size(), 6U);
  const std::vector<FeaturePair> held(apart.same.begin(), apart.same.begin() + 4);
  const std::vector<FeatureIndex> known{apart.same[4].one, apart.same[5].one};
  const std::vector<FeatureIndex> sightings{apart.same[4].other};
  std::vector<FeatureIndex> all(known);
  all.insert(all.end(), sightings.begin(), sightings.end());
  for (const FeaturePair& p : held) all.insert(all.end(), {p.one, p.other});
  CovarianceColumns<kDim> columns(apart.estimate);
  columns.add(all);
  AlignmentBranch<kDim> branch;
  branch.place({0, held, std::vector<Match>(held.size())}, columns);
  ASSERT_EQ(branch.held().size(), AlignmentBranch<kDim>::kFewest);
  const PairingProblem<kDim> problem = branch.problem(known, sightings, columns);

  const std::vector<PoseOrFeature> variables(all.begin(), all.end());
  const Eigen::MatrixXd C = apart.estimate.covariances->joint(variables).value();
  const auto rows = static_cast<Eigen::Index>(branch.held().size()) * kDim;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(rows, C.cols());
  Eigen::VectorXd x(C.cols());
  for (std::size_t k = 0; k < all.size(); ++k) {
    x.segment<kDim>(static_cast<Eigen::Index>(k) * kDim) = columns.position(all[k]);
    for (std::size_t h = 0; h < branch.held().size(); ++h) {
      const auto [one, other] = branch.held()[h];
      const double sign = all[k] == one ? 1.0 : all[k] == other ? -1.0 : 0.0;
      H.block<kDim, kDim>(static_cast<Eigen::Index>(h) * kDim, static_cast<Eigen::Index>(k) * kDim) =
          sign * PointMatrix<kDim>::Identity();
    }
  }
  const Eigen::MatrixXd gain = C * H.transpose() * (H * C * H.transpose()).inverse();
  const Eigen::VectorXd mean = x - gain * H * x;
  const Eigen::MatrixXd left = C - gain * H * C;
  EXPECT_LT((problem.known[0] - mean.segment<kDim>(0)).norm(), 1e-8);
  EXPECT_LT((problem.known[1] - mean.segment<kDim>(kDim)).norm(), 1e-8);
  EXPECT_LT((problem.sightings[0] - mean.segment<kDim>(2 * kDim)).norm(), 1e-8);
  EXPECT_LT((problem.covariance - left.topLeftCorner<3 * kDim, 3 * kDim>()).norm(), 1e-8 * C.norm());
}

TYPED_TEST(AlignmentBranchTest, IsChargedForWhereAMapIsPlacedNotForErrorsOfItsFeatures) {
  constexpr int kDim = TypeParam::value;
  const Apart<kDim> apart;
  CovarianceColumns<kDim> columns(apart.estimate);
  for (const FeaturePair& p : apart.same) columns.add(std::vector<FeatureIndex>{p.one, p.other});
  AlignmentBranch<kDim> once;
  once.place({0, apart.same, std::vector<Match>(apart.same.size())}, columns);
  EXPECT_GE(once.excess(), -kPoseDof<kDim>);
  EXPECT_LT(once.excess(), 30.0);
  AlignmentBranch<kDim> twice = once;
  twice.place({1, once.held(), std::vector<Match>(once.held().size())}, columns);  // the same pairs again
  EXPECT_EQ(twice.excess(), once.excess());
  EXPECT_EQ(twice.held().size(), once.held().size());
}

}  // namespace
}  // namespace mapjoin
