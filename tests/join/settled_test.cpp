// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <functional>
#include <map>
#include <mapjoin/join/settled.hpp>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// A solve that converged at `chi2` with 10 degrees of freedom, after `short_steps` steps that gained less than promised, with
/// a pose turned by `largest_rotation` (rad).
JoinResult found(double chi2, int short_steps, double largest_rotation) {
  JoinResult found;
  found.chi2 = chi2;
  found.dof = 10;
  found.short_steps = short_steps;
  found.largest_rotation = largest_rotation;
  return found;
}

/// Ways of joining that find what is given for each; bad input by the others.
class Ways {
 public:
  explicit Ways(std::map<Schedule, JoinResult> found) : found_(std::move(found)) {}

  Expected<JoinResult> best() {
    const auto find = [&](Schedule way) -> Expected<JoinResult> {
      tried.push_back(way);
      const auto known = found_.find(way);
      if (known == found_.end()) return bad_input("singular");
      JoinResult found = known->second;
      found.schedule = way;
      return found;
    };
    return best_of_ways<JoinResult>(find, std::identity());
  }

  std::vector<Schedule> tried;

 private:
  std::map<Schedule, JoinResult> found_;
};

using ::testing::ElementsAre;
constexpr Schedule kAligned = Schedule::kAligned;
constexpr Schedule kTree = Schedule::kTree;
constexpr Schedule kUnbalanced = Schedule::kUnbalanced;

TEST(BestOfWays, TakesTheFirstThatBeganNearItsOptimum) {
  Ways ways({{kAligned, found(9.0, 1, 0.5)}});
  EXPECT_TRUE(ways.best()->is_settled);
  EXPECT_THAT(ways.tried, ElementsAre(kAligned));
}

TEST(BestOfWays, TakesALaterOneOnlyWhereItWasAsGoodAsLinear) {
  Ways near({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(8.0, 1, 0.5)}, {kUnbalanced, found(7.0, 1, 2.0)}});
  EXPECT_EQ(near.best()->schedule, kUnbalanced);
  Ways linear({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(8.0, 0, 2.0)}});
  EXPECT_EQ(linear.best()->schedule, kTree);
  EXPECT_THAT(linear.tried, ElementsAre(kAligned, kTree));
}

TEST(BestOfWays, DoesNotBelieveGainsOfStepsAloneWhereChi2IsTooLarge) {
  Ways far({{kAligned, found(90.0, 0, 2.0)}, {kTree, found(60.0, 0, 0.5)}, {kUnbalanced, found(9.0, 0, 2.0)}});
  EXPECT_EQ(far.best()->schedule, kUnbalanced);
  EXPECT_TRUE(far.best()->is_settled);
  Ways near({{kAligned, found(90.0, 0, 0.5)}});
  EXPECT_TRUE(near.best()->is_settled) << "covariances may be too sure";
}

TEST(BestOfWays, BelievesAnOptimumThatTwoEndAtWhereOneOfThemCameFromNearBy) {
  Ways near({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(9.0, 1, 0.5)}});
  EXPECT_EQ(near.best()->schedule, kAligned);
  EXPECT_THAT(near.tried, ElementsAre(kAligned, kTree));
  Ways far({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(9.0, 1, 2.0)}, {kUnbalanced, found(7.0, 1, 2.0)}});
  EXPECT_EQ(far.best()->schedule, kUnbalanced);
}

TEST(BestOfWays, GoesOnWhereTheFirstOrALaterOneIsSingular) {
  Ways first({{kTree, found(9.0, 0, 0.5)}});
  EXPECT_EQ(first.best()->schedule, kTree);
  Ways later({{kAligned, found(9.0, 1, 2.0)}, {kUnbalanced, found(7.0, 1, 2.0)}});
  EXPECT_EQ(later.best()->schedule, kUnbalanced);
  Ways none({});
  EXPECT_FALSE(none.best().has_value());
  EXPECT_THAT(none.tried, ElementsAre(kAligned, kTree));
}

TEST(BestOfWays, ConfirmsWhatSettlesItselfOrTwoEndAtFromNearBy) {
  EXPECT_EQ(Ways({{kAligned, found(9.0, 1, 0.5)}}).best()->is_confirmed, true);
  EXPECT_EQ(Ways({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(8.0, 0, 2.0)}}).best()->is_confirmed, true);
  EXPECT_EQ(Ways({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(9.0, 1, 0.5)}}).best()->is_confirmed, true);
}

TEST(BestOfWays, DoesNotConfirmTheBestOfOptimaThatDifferOrOneThatIsFarFromEveryStart) {
  const JoinResult aligned = found(9.0, 1, 2.0);
  EXPECT_EQ(Ways({{kAligned, aligned}, {kTree, found(8.0, 1, 0.5)}, {kUnbalanced, found(7.0, 1, 2.0)}}).best()->is_confirmed,
            false);
  EXPECT_EQ(Ways({{kAligned, aligned}, {kTree, found(9.0, 1, 2.0)}, {kUnbalanced, found(9.0, 1, 2.0)}}).best()->is_confirmed,
            false);
  EXPECT_EQ(Ways({{kAligned, aligned}}).best()->is_confirmed, false);
}

TEST(BestOfWays, EndsAtOtherErrors) {
  int calls = 0;
  const auto find = [&](Schedule) -> Expected<JoinResult> {
    ++calls;
    return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted"});
  };
  const auto interrupted = best_of_ways<JoinResult>(find, std::identity());
  EXPECT_EQ(interrupted.error().kind, ErrorKind::kInterrupted);
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace mapjoin
