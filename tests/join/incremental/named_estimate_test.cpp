// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/incremental/named_estimate.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class NamedEstimateTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Enters all updates of a world into both estimates, at the optimum.
  NamedEstimateTest() {
    const SubmapSet<kDim> set = testing::set_of_all(updates_);
    const Join<kDim> joined = testing::batch_join(pointers());
    for (NamedEstimate<kDim>* estimate : {&estimate_, &untouched_}) {
      for (const auto& update : updates_) estimate->enter_at(update, JoinedSet<kDim>(set, joined));
      estimate->settle({});
    }
  }
  std::vector<const SubmapUpdate<kDim>*> pointers() const {
    std::vector<const SubmapUpdate<kDim>*> all;
    for (const auto& update : updates_) all.push_back(&update);
    return all;
  }
  /// A closure that is off by so many metres along x.
  SubmapUpdate<kDim> closure(double metres) const {
    SubmapUpdate<kDim> update;
    update.poses = {first_pose(updates_[2]), last_pose(updates_[8])};
    Pose<kDim> measured = between(*estimate_.pose(update.poses[0]), *estimate_.pose(update.poses[1]));
    measured.translation.x() += metres;
    update.graph.pose_factors = {{0, 1, measured, 3e4 * PoseMatrix<kDim>::Identity(), {}}};
    return update;
  }
  /// The distance of a pose from its place in the untouched estimate, in standard deviations.
  double deviations(const PoseId& id) {
    const PoseVector<kDim> step = local(*untouched_.pose(id), *estimate_.pose(id));
    return std::sqrt(step.dot(untouched_.snapshot()->covariance(id).value().llt().solve(step)));
  }

  std::vector<SubmapUpdate<kDim>> updates_ =
      testing::parts_of_log(testing::small_world<kDim>({.poses = 60, .features = 60, .closures = 6}).log, 6.0);
  NamedEstimate<kDim> estimate_;
  NamedEstimate<kDim> untouched_;
};
TYPED_TEST_SUITE(NamedEstimateTest, testing::Dimensions);

TYPED_TEST(NamedEstimateTest, WhatLeavesTakesItsEffectWithIt) {
  auto& estimate = this->estimate_;
  const auto wrong = this->closure(0.3);
  const PoseId end = wrong.poses[1];
  ASSERT_TRUE(estimate.enter(wrong));
  EXPECT_TRUE(estimate.settle({}).converged);
  EXPECT_GT(this->deviations(end), 2.0);
  EXPECT_GT(estimate.chi2(), this->untouched_.chi2() + 10.0);
  estimate.leave(wrong);
  const Settling settling = estimate.settle({});
  EXPECT_TRUE(settling.converged);
  EXPECT_GT(settling.eliminated, 0u);
  // A linearisation may err by 1e-5 in chi2 per row.
  EXPECT_NEAR(estimate.chi2(), this->untouched_.chi2(), 1e-5 * static_cast<double>(2 * estimate.dof()));
  EXPECT_EQ(estimate.dof(), this->untouched_.dof());
  for (const auto& update : this->updates_) {
    if (first_pose(update) != first_pose(this->updates_[0])) {
      EXPECT_LT(this->deviations(first_pose(update)), 0.1);
    }
  }
  const auto expected = this->untouched_.snapshot()->covariance(end).value();
  EXPECT_LT((estimate.snapshot()->covariance(end).value() - expected).norm(), 0.01 * expected.norm());
}

TYPED_TEST(NamedEstimateTest, WhatLeavesMayComeBack) {
  auto& estimate = this->estimate_;
  const auto right = this->closure(0.0);
  estimate.enter(right);
  estimate.settle({});
  const double chi2 = estimate.chi2();
  const auto covariance = estimate.snapshot()->covariance(right.poses[1]).value();
  for (int k = 0; k < 3; ++k) {
    estimate.leave(right);
    if (k != 1) estimate.settle({});
    estimate.enter(right);
    estimate.settle({});
    EXPECT_NEAR(estimate.chi2(), chi2, 1e-6 * chi2);
    EXPECT_LT((estimate.snapshot()->covariance(right.poses[1]).value() - covariance).norm(), 1e-6 * covariance.norm());
  }
}

TYPED_TEST(NamedEstimateTest, TwoPosesHaveAJointCovariance) {
  constexpr int kDof = kPoseDof<TestFixture::kDim>;
  const auto snapshot = this->untouched_.snapshot();
  const PoseId anchored = first_pose(this->updates_[0]);
  const PoseId one = last_pose(this->updates_[3]);
  const PoseId two = last_pose(this->updates_[6]);
  const auto both = snapshot->covariance(one, two).value();
  EXPECT_LT((both.template topLeftCorner<kDof, kDof>() - *snapshot->covariance(one)).norm(), 1e-12);
  EXPECT_LT((both.template bottomRightCorner<kDof, kDof>() - *snapshot->covariance(two)).norm(), 1e-12);
  const auto other_way = snapshot->covariance(two, one).value();
  EXPECT_LT((both.template topRightCorner<kDof, kDof>() - other_way.template bottomLeftCorner<kDof, kDof>()).norm(), 1e-12);
  const auto with_anchored = snapshot->covariance(anchored, two).value();
  EXPECT_EQ((with_anchored.template topRows<kDof>().norm()), 0.0);
  EXPECT_LT((with_anchored.template bottomRightCorner<kDof, kDof>() - *snapshot->covariance(two)).norm(), 1e-12);
  EXPECT_FALSE(snapshot->covariance(one, PoseId{9, 9}));
}

}  // namespace
}  // namespace mapjoin
