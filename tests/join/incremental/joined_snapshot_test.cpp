// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// The estimate of a pose and its covariance, nullopt if it has none.
template <int Dim>
struct Answer {
  Pose<Dim> pose;
  std::optional<PoseMatrix<Dim>> covariance;

  static Answer of(const JoinedSnapshot<Dim>& snapshot, const PoseId& id) {
    return {snapshot.pose(id).value(), snapshot.covariance(id)};
  }
  bool operator==(const Answer& other) const {
    return pose.translation == other.pose.translation && local(pose, other.pose).norm() == 0.0 &&
           covariance == other.covariance;
  }
};

template <typename D>
class JoinedSnapshotTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  using Updates = std::vector<SubmapUpdate<kDim>>;

  /// Updates of a world whose closures move and rotate poses of long before.
  const Updates updates_ =
      testing::parts_of_log(testing::small_world<kDim>({.poses = 100, .features = 60, .closures = 6}).log, 6.0);
};
TYPED_TEST_SUITE(JoinedSnapshotTest, testing::Dimensions);

TYPED_TEST(JoinedSnapshotTest, StaysAsItIsWhateverIsAdded) {
  constexpr int kDim = TestFixture::kDim;
  using Kept = std::tuple<std::shared_ptr<const JoinedSnapshot<kDim>>, PoseId, Answer<kDim>, double>;
  std::vector<Kept> kept;
  {
    IncrementalJoin<kDim> joined;
    EXPECT_FALSE(joined.snapshot()->pose(first_pose(this->updates_.front())));
    for (const auto& update : this->updates_) {
      joined.add(update).value();
      const auto snapshot = joined.snapshot();
      const PoseId id = last_pose(update);
      EXPECT_EQ(local(*joined.pose(id), snapshot->pose(id).value()).norm(), 0.0);
      for (const FeatureId& feature : update.features) EXPECT_EQ(*joined.feature(feature), snapshot->feature(feature));
      EXPECT_EQ(snapshot->chi2(), joined.chi2());
      EXPECT_EQ(snapshot->dof(), joined.dof());
      kept.emplace_back(snapshot, id, Answer<kDim>::of(*snapshot, id), snapshot->chi2());
    }
    const PoseId moved = std::get<PoseId>(kept[1]);
    EXPECT_FALSE(std::get<Answer<kDim>>(kept[1]) == Answer<kDim>::of(*joined.snapshot(), moved));
  }  // the join itself is gone
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const auto& [snapshot, id, answer, chi2] = kept[k];
    EXPECT_TRUE(Answer<kDim>::of(*snapshot, id) == answer) << k;
    EXPECT_EQ(snapshot->chi2(), chi2);
    if (k + 1 < kept.size()) {
      EXPECT_FALSE(snapshot->pose(std::get<PoseId>(kept[k + 1])));
      EXPECT_FALSE(snapshot->covariance(std::get<PoseId>(kept[k + 1])));
    }
  }
}

/// Answers to other threads while maps are added are those after one of the updates, to the last bit.
TYPED_TEST(JoinedSnapshotTest, AnswersOtherThreadsWhileMapsAreAdded) {
  constexpr int kDim = TestFixture::kDim;
  const PoseId asked = last_pose(this->updates_.front());
  std::vector<std::pair<double, Answer<kDim>>> expected;  // with chi2
  IncrementalJoin<kDim> alone;
  for (const auto& update : this->updates_) {
    alone.add(update).value();
    expected.emplace_back(alone.chi2(), Answer<kDim>::of(*alone.snapshot(), asked));
  }
  IncrementalJoin<kDim> joined;
  joined.add(this->updates_.front()).value();
  std::atomic<bool> is_over = false;
  std::atomic<std::size_t> asks = 0;
  const auto ask = [&] {
    do {
      const auto snapshot = joined.snapshot();
      const std::pair answered(snapshot->chi2(), Answer<kDim>::of(*snapshot, asked));
      ASSERT_TRUE(std::ranges::find(expected, answered) != expected.end());
      ++asks;
    } while (!is_over);
  };
  {
    std::jthread a(ask), b(ask);
    for (std::size_t k = 1; k < this->updates_.size(); ++k) {
      const std::size_t before = asks;
      joined.add(this->updates_[k]).value();
      while (asks < before + 2 && !::testing::Test::HasFatalFailure()) std::this_thread::yield();
    }
    is_over = true;
  }
  EXPECT_GE(asks, 2 * this->updates_.size());
}

}  // namespace
}  // namespace mapjoin
