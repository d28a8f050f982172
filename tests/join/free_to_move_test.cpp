// SPDX-License-Identifier: BSD-3-Clause
// Small logs that leave something free to move, each with its message.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/temporary_folder.hpp>
#include <variant>
#include <vector>

namespace mapjoin {
namespace {

using ::testing::Each;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

/// The error of a run on a log in the plane; empty if there is none.
std::string said_of(const std::string& g2o) {
  const testing::TemporaryFolder folder;
  const auto log = open_log(folder.file("log.g2o", g2o));
  return testing::error_of(run(std::get<Log<2>>(*log), RunOptions()));
}

TEST(FreeToMove, TwoSessionsWithOneFeatureTurnAboutIt) {
  EXPECT_THAT(
      said_of("EDGE_SE2 0 1 1 0 0 100 0 0 100 0 400\n"
              "EDGE_SE2 5 6 1 0 0 100 0 0 100 0 400\n"
              "EDGE_SE2_XY 1 7 0 1 25 0 25\n"
              "EDGE_SE2_XY 5 7 0 1 25 0 25\n"),
      HasSubstr("pose 5 and pose 6 cannot be determined: the observations leave them free to turn as a whole about feature 7"));
}

TEST(FreeToMove, APoseWithoutHeadingTurns) {
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\n"),
              HasSubstr("pose 1 cannot be determined: the observations leave it free to turn"));
}

TEST(FreeToMove, AllPosesWithoutHeadingAreCounted) {
  std::string chain;
  for (int pose = 0; pose < 30; ++pose) {
    chain += "EDGE_SE2 " + std::to_string(pose) + " " + std::to_string(pose + 1) + " 1 0 0 1 0 0 1 0 0\n";
  }
  EXPECT_THAT(said_of(chain), HasSubstr("pose 1, pose 2, pose 3 and 27 others cannot be determined"));
}

TEST(FreeToMove, AFeatureSeenAlongOneAxisMoves) {
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1 0 0 100 0 0 100 0 400\n"
                      "EDGE_SE2_XY 0 7 1 1 25 0 0\n"
                      "EDGE_SE2_XY 1 7 0 1 25 0 0\n"),
              HasSubstr("feature 7 cannot be determined: the observations leave it free to move"));
}

TEST(FreeToMove, WeightsTooFarApartAreNamed) {
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
                      "EDGE_SE2 1 2 1 0 0 1e100 0 0 1e100 0 1e100\n"
                      "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\n"),
              HasSubstr("weights from 1 to 1e+100 are too far apart"));
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\n"), Not(HasSubstr("weights")));
}

TEST(FreeToMove, EqualWeightsAreTooFarApartInAVeryLargeMap) {
  EXPECT_THAT(said_of("EDGE_SE2 0 1 1e9 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 0 1e9 0 1 0 0 1 0 1\n"),
              HasSubstr("weights from 1 to 1 are too far apart to be added, as those of positions count times the square of "
                        "the map's 1.4e+09 m"));
}

TEST(FreeToMove, WeightsADozenDigitsApartAreNot) {
  EXPECT_EQ(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
                    "EDGE_SE2 1 2 1 0 0 1e12 0 0 1e12 0 1e12\n"
                    "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\n"),
            "");
}

TEST(FreeToMove, TheWholeTurnsAboutItsOnePriorInAnyUnitOfLength) {
  for (const double unit : {1e-3, 1.0, 1e5, 1e7}) {
    const double weight = 1.0 / (unit * unit);
    std::string log = fmt::format("EDGE_PRIOR_SE2_XY 0 0 0 {0} 0 {0}\n", weight);
    for (int pose = 0; pose < 12; ++pose) {
      log += fmt::format("EDGE_SE2 {} {} {} 0 0.3 {} 0 0 {} 0 100\n", pose, pose + 1, unit, weight, weight);
    }
    EXPECT_THAT(said_of(log), EndsWith("free to turn as a whole about pose 0")) << unit;
  }
}

TEST(FreeToMove, OneEdgeIsEnough) {
  EXPECT_EQ(said_of("EDGE_SE2 0 1 1 0 0 100 0 0 100 0 400\n"), "");
}

/// The walks of two robots in one log; they share the first feature that each sees, and nothing else.
template <int Dim>
Log<Dim> hinged(std::uint64_t seed) {
  constexpr std::uint64_t kHinge = 1'000'000;
  LogBuilder<Dim> builder("hinged");
  for (std::uint32_t robot = 0; robot < 2; ++robot) {
    const Log<Dim> log = simulate_manhattan<Dim>({.poses = 150, .seed = seed + robot}).log;
    const auto pose = [&](PoseIndex p) { return PoseId{robot, log.poses[p].key}; };
    const auto feature = [&](FeatureIndex f) {
      return FeatureId{f == 0 ? kHinge : 1000 * robot + static_cast<std::uint64_t>(f.value)};
    };
    for (const auto& e : log.edges()) builder.add_pose_edge(pose(e.base), pose(e.target), e.measured, e.information);
    for (const auto& o : log.observations()) {
      builder.add_observation(pose(o.base), feature(o.target), o.measured, o.information);
    }
  }
  return std::move(builder).finish().value();
}

/// A walk that priors on the positions of some poses hold in the World.
template <int Dim>
Log<Dim> held_at(const std::vector<PoseIndex>& poses, std::uint64_t seed, double weight = 25.0) {
  const Simulation<Dim> world = simulate_manhattan<Dim>({.poses = 600, .seed = seed});
  Log<Dim> log = world.log;
  log.graph.fixed.clear();
  for (const PoseIndex pose : poses) {
    PoseVector<Dim> weights = PoseVector<Dim>::Zero();
    weights.template head<Dim>().setConstant(weight);
    log.graph.pose_factors.push_back({kWorld, pose, {world.truth.poses[pose].translation, {}}, weights.asDiagonal()});
  }
  return log;
}

/// The errors of a log by run() and by solve(), by each method, state and engine; those of CHOLMOD last.
template <int Dim>
std::vector<std::string> errors_of(const Log<Dim>& log) {
  std::vector<RunOptions> ways(4);
  ways[1].solver.method = Method::kLevenbergMarquardt;
  ways[2].state = JoinedState::kRelative;
  ways[3].solver.engine = Engine::kCholmod;
  std::vector<std::string> errors;
  for (const RunOptions& options : ways) {
    errors.push_back(testing::error_of(run(log, options)));
    errors.push_back(testing::error_of(solve(log, options)));
  }
  return errors;
}

/// Expects that the log is refused in every way, as free to move like `how`. CHOLMOD may meet a singular pivot where mapjoin's
/// own factorisation, which names the directions, does not.
template <int Dim>
void expect_free(const Log<Dim>& log, const std::string& how) {
  const std::vector<std::string> errors = errors_of(log);
  EXPECT_THAT(errors, Each(HasSubstr("cannot be determined")));
  EXPECT_THAT(std::vector(errors.begin(), errors.end() - 2), Each(HasSubstr(how)));
}

template <typename D>
class HiddenFreedom : public ::testing::Test {};
TYPED_TEST_SUITE(HiddenFreedom, testing::Dimensions);

TYPED_TEST(HiddenFreedom, OfAMapWithOnePositionIsFound) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    expect_free(held_at<TypeParam::value>({0}, seed), "turn as a whole about pose 0");
  }
}

TYPED_TEST(HiddenFreedom, OfRobotsThatShareOneFeatureIsFound) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    expect_free(hinged<TypeParam::value>(seed), "turn as a whole about feature 1000000");
  }
}

TYPED_TEST(HiddenFreedom, IsNoneWhereWeakPriorsHoldAMap) {
  for (const double weight : {25.0, 1e-6}) {
    EXPECT_THAT(errors_of(held_at<TypeParam::value>({0, 200, 300, 599}, 1, weight)), Each("")) << weight;
  }
}

TEST(FreeToMove, APoseWhosePositionAndHeadingAreMeasuredApartIsHeld) {
  EXPECT_EQ(said_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 0\n"
                    "EDGE_SE2 0 1 1 0 0 0 0 0 0 0 1\n"),
            "");
}

}  // namespace
}  // namespace mapjoin
