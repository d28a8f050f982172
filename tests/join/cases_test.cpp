// SPDX-License-Identifier: BSD-3-Clause
// Logs that are hard to join (data/cases).
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <tests/support/data.hpp>
#include <tests/support/places.hpp>
#include <variant>

namespace mapjoin {
namespace {

using ::testing::TestWithParam;

struct Figures {
  RunFigures run;
  std::string error;  // empty if there is a map
};

Figures figures_of(const std::filesystem::path& file, const RunOptions& options) {
  const auto figures = [&](const auto& log) -> Figures {
    const auto result = run(log, options);
    if (!result) return {{}, result.error().message};
    return {*result, {}};
  };
  return std::visit(figures, open_log(file).value());
}

Figures figures_of_case(const std::string& name, const RunOptions& options) {
  return figures_of(testing::kBundledData / "cases" / name, options);
}

class FreeToMove : public TestWithParam<const char*> {};

TEST_P(FreeToMove, IsSaidInTheSameWordsByEveryMethod) {
  RunOptions options;
  const std::string error = figures_of_case(GetParam(), options).error;
  EXPECT_NE(error.find("cannot be determined: the observations leave"), std::string::npos) << error;
  for (const auto method : {Method::kGaussNewton, Method::kLevenbergMarquardt}) {
    options.solver.method = method;
    EXPECT_EQ(figures_of_case(GetParam(), options).error, error) << to_string(method);
  }
}
INSTANTIATE_TEST_SUITE_P(Cases, FreeToMove,
                         ::testing::Values("onefeature.g2o", "free.g2o", "freefeature.g2o", "lm_accepts_free_feature.g2o",
                                           "lm_covariances_of_singular.g2o"));

TEST(Cases, DampingGivesNoCovariancesToWhatIsFree) {
  RunOptions options;
  options.solver.method = Method::kLevenbergMarquardt;
  options.schedule = Schedule::kAligned;
  options.split = {SplitRule::kPoses, 20.0};
  options.covariances = options.marginals = true;
  EXPECT_FALSE(figures_of_case("lm_covariances_of_singular.g2o", options).error.empty());
}

TEST(Cases, AMapHasConvergedWhereNothingIsLeftToGainHoweverItWasFound) {
  RunOptions options;
  options.schedule = Schedule::kBatch;
  options.split = {SplitRule::kPoses, 3.0};
  const auto refined = figures_of_case("polish_false_alarm_1266.g2o", options);
  EXPECT_TRUE(refined.run.converged());
  EXPECT_NEAR(refined.run.chi2, 265.2843, 1e-4);
  EXPECT_TRUE(figures_of_case("tight_1433.g2o", RunOptions{}).run.converged());
}

/// A line of `steps` steps of 1 m that strays to both sides, with a closure from its first pose to its last that stretches it.
Log<2> stretched_line(std::uint32_t steps) {
  const Matrix<3> W = Vector<3>(400.0, 400.0, 2500.0).asDiagonal();
  LogBuilder<2> builder("line");
  RandomStream random(1, 0);
  for (std::uint32_t k = 0; k < steps; ++k) {
    const Pose<2> step{{1.0 + 0.05 * random.normal(), 0.05 * random.normal()}, Rotation<2>(0.02 * random.normal())};
    builder.add_pose_edge({k}, {k + 1}, step, W);
  }
  builder.add_pose_edge({0}, {steps}, {{static_cast<double>(steps), 0.0}, {}}, W);
  return std::move(builder).finish().value();
}

TEST(Cases, ALongLineIsStraightenedInFewSteps) {
  RunOptions options;
  for (const auto state : {JoinedState::kAbsolute, JoinedState::kRelative}) {
    options.state = state;
    const auto joined = run(stretched_line(3000), options).value();
    EXPECT_TRUE(joined.converged());
    EXPECT_LT(joined.join.iterations, 75) << to_string(state);
    EXPECT_NEAR(joined.chi2, 27.7494557, 1e-6);
  }
}

class WrongClosures : public TestWithParam<const char*> {};

TEST_P(WrongClosures, AreAMisfitThoughTheMapConverged) {
  const RunFigures figures = figures_of_case(GetParam(), {}).run;
  EXPECT_TRUE(figures.converged());
  EXPECT_EQ(figures.fit.verdict, Verdict::kMisfit);
}
INSTANTIATE_TEST_SUITE_P(Cases, WrongClosures, ::testing::Values("A_1900.g2o", "A_2442.g2o", "B_100406.g2o", "tight_1433.g2o"));

TEST(CasesData, AWrongClosureOfHugeInformationIsNamedFirst) {
  auto log = std::get<Log<2>>(open_log(testing::data_file("dlr/dlr_corrected.g2o.gz")).value());
  const IndexOf index_of(log.poses);
  const PoseIndex base = index_of({0, 1291}).value();
  const PoseIndex target = index_of({0, 1739}).value();
  const Pose<2> measured{{0.00194, -0.1501}, Rotation<2>(0.04944)};
  log.graph.pose_factors.push_back({base, target, measured, 5e4 * PoseMatrix<2>::Identity()});
  put_in_order(log);
  const GoodnessOfFit fit = run(log, {}).value().fit;
  ASSERT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_EQ(fit.misfits.at(0).kind, PartKind::kClosure);
  EXPECT_EQ(fit.misfits.at(0).from, base);
  EXPECT_EQ(fit.misfits.at(0).to, PoseOrFeature(target));
}

TEST(CasesData, AFlatValleyIsFollowedToItsEnd) {
  const auto found = figures_of(testing::data_file("robots/robot_b.g2o"), RunOptions{});
  EXPECT_TRUE(found.run.converged());
  EXPECT_NEAR(found.run.chi2, 20.36719, 1e-4);
}

}  // namespace
}  // namespace mapjoin
