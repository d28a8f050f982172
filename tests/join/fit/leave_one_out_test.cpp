// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/restored.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <memory>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

/// Noise (m, rad) so small that everything is linear: chi2 of a log without an observation is what theory predicts.
constexpr double kNoise = 1e-4;

template <typename D>
class LeaveOneOutTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  static Log<kDim> world() {
    return testing::small_world<kDim>({.poses = 24, .features = 14, .closures = 4, .range = 3.0, .noise = kNoise}).log;
  }

  /// The tests of all factors of a log or a set of maps, at its optimum.
  struct Tests {
    explicit Tests(Restored<kDim> made) : restored(std::move(made)) {
      restored.system.linearise();
      EXPECT_FALSE(restored.system.factorise(0.0));
      const NormalEquations& equations = restored.system.equations();
      marginals = std::make_unique<Marginals>(equations);
      leave_one_out = std::make_unique<LeaveOneOut<kDim>>(restored.system, equations, *marginals);
    }
    const JoiningSystem<kDim>& system() const { return restored.system; }
    std::size_t factors() const { return system().equations().pattern().factors.size(); }
    MeasuredPart whole(std::size_t factor) const { return {factor, 0, system().rows(factor)}; }
    /// The index of the factor of an observation of the log; factors() if there is none.
    template <typename Observation>
    std::size_t factor_of(const Observation& observation) const {
      for (std::size_t k = 0; k < factors(); ++k) {
        const auto [kind, place] = system().source_of(k);
        const void* of_k = kind == JoiningSystem<kDim>::Source::kPoseFactor
                               ? static_cast<const void*>(system().pose_factors()[place].observation)
                               : static_cast<const void*>(system().feature_factors()[place].observation);
        if (of_k == &observation) return k;
      }
      return factors();
    }

    Restored<kDim> restored;
    std::unique_ptr<Marginals> marginals;
    std::unique_ptr<LeaveOneOut<kDim>> leave_one_out;
  };

  template <typename Data>
  static Restored<kDim> restored_at_optimum(const SubmapGraph<kDim>& graph, const Data& data) {
    JoinOptions<kDim> options;
    options.solver.relative_chi2 = 1e-14;
    Join<kDim> joined = join(graph, data.poses, data.features, options).value();
    return restored(graph, {}, joined, joined.state);
  }
  static Restored<kDim> full_slam(const Log<kDim>& log) {
    return restored_at_optimum(submap_graph_of(log, split(log, {SplitRule::kPoses, 1.0}), {}), log);
  }
  static double chi2_of(const Log<kDim>& log) {
    RunOptions options = without_verdict();
    options.solver.relative_chi2 = 1e-14;
    return solve(log, options).value().chi2;
  }
  /// A copy of the log without the closure and the observation at these places in their lists; -1 leaves none out.
  static Log<kDim> without(const Log<kDim>& log, std::ptrdiff_t closure, std::ptrdiff_t observation) {
    Log<kDim> less = log;
    if (closure >= 0) less.graph.pose_factors.erase(less.graph.pose_factors.begin() + std::ssize(log.odometry()) + closure);
    if (observation >= 0) less.graph.feature_factors.erase(less.graph.feature_factors.begin() + observation);
    return less;
  }
  static std::ptrdiff_t sightings(const Log<kDim>& log, std::ptrdiff_t observation) {
    const FeatureIndex feature = log.observations()[static_cast<std::size_t>(observation)].target;
    return std::ranges::count(log.observations(), feature, &FeatureFactor<kDim>::target);
  }
};
TYPED_TEST_SUITE(LeaveOneOutTest, testing::Dimensions, );

TYPED_TEST(LeaveOneOutTest, SaysByHowMuchChi2FallsWithoutAClosureOrAnObservation) {
  const auto log = this->world();
  const typename TestFixture::Tests tests(this->full_slam(log));
  const double chi2 = this->chi2_of(log);
  EXPECT_NEAR(tests.leave_one_out->chi2(), chi2, 1e-7 * chi2);
  for (std::ptrdiff_t c = 0; c < std::ssize(log.closures()); ++c) {
    const auto test = tests.leave_one_out->test(tests.whole(tests.factor_of(log.closures()[static_cast<std::size_t>(c)])));
    EXPECT_EQ(test.rows, kPoseDof<TypeParam::value>);
    EXPECT_NEAR(test.chi2, chi2 - this->chi2_of(this->without(log, c, -1)), 1e-3 * test.chi2) << "closure " << c;
  }
  int tested = 0;
  for (std::ptrdiff_t o = 0; o < std::ssize(log.observations()); o += 5) {
    if (this->sightings(log, o) < 2) continue;
    const auto test = tests.leave_one_out->test(tests.whole(tests.factor_of(log.observations()[static_cast<std::size_t>(o)])));
    EXPECT_EQ(test.rows, TypeParam::value);
    EXPECT_NEAR(test.chi2, chi2 - this->chi2_of(this->without(log, -1, o)), 1e-3 * test.chi2) << "observation " << o;
    ++tested;
  }
  EXPECT_GT(tested, 5);
}

TYPED_TEST(LeaveOneOutTest, TestsASharpClosureOfALongLoopOnceSolvedFor) {
  constexpr int kDim = TypeParam::value;
  auto log = testing::small_world<kDim>({.poses = 24, .features = 0, .closures = 1, .noise = kNoise}).log;
  log.graph.pose_factors.back().information *= 1e5;
  const typename TestFixture::Tests tests(this->full_slam(log));
  const MeasuredPart closure = tests.whole(tests.factor_of(log.closures()[0]));
  std::stop_source stop;
  stop.request_stop();
  tests.leave_one_out->solve_for_weak(std::array{closure.factor}, stop.get_token());
  EXPECT_LT(tests.leave_one_out->test(closure).rows, kPoseDof<kDim>);
  tests.leave_one_out->solve_for_weak(std::array{closure.factor});
  const PartTest test = tests.leave_one_out->test(closure);
  const double chi2 = this->chi2_of(log);  // all of it, as nothing is redundant without the closure
  EXPECT_EQ(test.rows, kPoseDof<kDim>);
  EXPECT_NEAR(test.chi2, chi2, 1e-3 * chi2);
  tests.leave_one_out->leave_out(closure);
  const MeasuredPart step = tests.whole(tests.factor_of(log.odometry()[10]));
  EXPECT_EQ(tests.leave_one_out->test(step).rows, 0);
}

TYPED_TEST(LeaveOneOutTest, TestsWhatIsLeftOnceAPartIsOut) {
  const auto log = this->world();
  const auto less = this->without(log, 1, -1);
  const double chi2 = this->chi2_of(less);
  const typename TestFixture::Tests tests(this->full_slam(log));
  LeaveOneOut<TypeParam::value>& leave_one_out = *tests.leave_one_out;
  const MeasuredPart out = tests.whole(tests.factor_of(log.closures()[1]));
  EXPECT_LT(leave_one_out.leave_out(out), 0.01);
  EXPECT_EQ(leave_one_out.test(out).rows, 0);
  const auto closure = leave_one_out.test(tests.whole(tests.factor_of(log.closures()[2])));
  EXPECT_NEAR(closure.chi2, chi2 - this->chi2_of(this->without(less, 1, -1)), 1e-3 * closure.chi2);
  std::ptrdiff_t o = 3;
  while (this->sightings(log, o) < 3) ++o;
  const auto observation = leave_one_out.test(tests.whole(tests.factor_of(log.observations()[static_cast<std::size_t>(o)])));
  EXPECT_NEAR(observation.chi2, chi2 - this->chi2_of(this->without(less, -1, o)), 1e-3 * observation.chi2);
}

/// All closures, one after the other, and then steps of odometry, which are tied to them and to each other.
TYPED_TEST(LeaveOneOutTest, TestsWhatIsLeftOnceSeveralTiedPartsAreOut) {
  const auto log = this->world();
  auto less = log;
  const typename TestFixture::Tests tests(this->full_slam(log));
  double chi2 = this->chi2_of(log);
  for (const std::size_t place : {0U, 1U, 2U, 3U, 10U, 12U}) {
    const auto& edge = place < log.closures().size() ? log.closures()[place] : log.odometry()[place];
    const MeasuredPart part = tests.whole(tests.factor_of(edge));
    const auto test = tests.leave_one_out->test(part);
    std::erase_if(less.graph.pose_factors, [&](const auto& o) { return o.base == edge.base && o.target == edge.target; });
    const double rest = this->chi2_of(less);
    EXPECT_NEAR(test.chi2, chi2 - rest, 1e-3 * test.chi2) << place;
    chi2 = rest;
    tests.leave_one_out->leave_out(part);
  }
}

TYPED_TEST(LeaveOneOutTest, PredictsWhatHadNoPartInTheEstimate) {
  constexpr int kDim = TypeParam::value;
  for (const bool is_whole : {true, false}) {
    auto log = this->world();
    PoseFactor<kDim>& closure = log.graph.pose_factors[log.odometry().size() + 2];
    if (!is_whole) {  // its rotation is not measured
      closure.information.template rightCols<kRotationDof<kDim>>().setZero();
      closure.information.template bottomRows<kRotationDof<kDim>>().setZero();
    }
    const double gain = this->chi2_of(log) - this->chi2_of(this->without(log, 2, -1));
    closure.loss = {0.0, 0.0};
    const typename TestFixture::Tests tests(this->full_slam(log));
    closure.loss = {};
    const PartTest prediction = tests.leave_one_out->prediction(tests.factor_of(closure));
    EXPECT_NEAR(prediction.chi2, gain, 1e-3 * gain);
    EXPECT_EQ(prediction.rows, kPoseDof<kDim>);
  }
}

TYPED_TEST(LeaveOneOutTest, DoesNotTestWhatNothingElseConfirms) {
  auto log = this->world();
  log.graph.pose_factors.resize(log.odometry().size());
  log.graph.feature_factors.resize(1);
  log.graph.feature_factors.front().target = 0;
  log.features.resize(1);
  const typename TestFixture::Tests tests(this->full_slam(log));
  for (std::size_t k = 0; k < tests.factors(); ++k) EXPECT_EQ(tests.leave_one_out->test(tests.whole(k)).rows, 0);
}

TYPED_TEST(LeaveOneOutTest, DoesNotTestWhatSaysNothing) {
  auto log = this->world();
  log.graph.pose_factors.back().information.setZero();
  const typename TestFixture::Tests tests(this->full_slam(log));
  EXPECT_EQ(tests.leave_one_out->test(tests.whole(tests.factor_of(log.graph.pose_factors.back()))).rows, 0);
}

TYPED_TEST(LeaveOneOutTest, TestsOnlyTheMeasuredRowsOfAPosition) {
  constexpr int kDim = TypeParam::value;
  auto log = this->world();
  PoseFactor<kDim> gps{kWorld, 9, Pose<kDim>{}, PoseMatrix<kDim>::Zero()};
  gps.information.template topLeftCorner<kDim, kDim>().setIdentity();
  for (const std::size_t pose : {3U, 9U, 15U, 20U}) {
    gps.target = PoseIndex(pose);
    log.graph.pose_factors.push_back(gps);
  }
  const typename TestFixture::Tests tests(this->full_slam(log));
  EXPECT_EQ(tests.leave_one_out->test(tests.whole(tests.factor_of(log.graph.pose_factors.back()))).rows, kDim);
}

/// The redundancies of all parts add up to the degrees of freedom, also with factors that do not measure all of their rows.
TYPED_TEST(LeaveOneOutTest, SharesTheDegreesOfFreedomAmongAllParts) {
  constexpr int kDim = TypeParam::value;
  auto log = this->world();
  for (const std::size_t pose : {3U, 9U, 15U, 20U}) {
    PoseFactor<kDim> gps{kWorld, PoseIndex(pose), Pose<kDim>{}, PoseMatrix<kDim>::Zero()};
    gps.information.template topLeftCorner<kDim, kDim>().setIdentity();
    log.graph.pose_factors.push_back(gps);
  }
  const typename TestFixture::Tests tests(this->full_slam(log));
  double sum = 0.0;
  for (std::size_t k = 0; k < tests.factors(); ++k) sum += tests.leave_one_out->test(tests.whole(k)).redundancy;
  EXPECT_NEAR(sum, static_cast<double>(degrees_of_freedom(log, 0)), 1e-3);
}

TYPED_TEST(LeaveOneOutTest, TestsAFeatureOfALocalMapAsTheMapWithoutIt) {
  constexpr int kDim = TypeParam::value;
  const auto set = testing::small_submap_set(this->world(), 6.0);
  const typename TestFixture::Tests tests(this->restored_at_optimum(submap_graph_of(set), set));
  RunOptions options = without_verdict();
  options.solver.relative_chi2 = 1e-14;
  const double chi2 = run(set, options).value().chi2;
  int tested = 0;
  std::size_t first = 0;
  while (tests.system().source_of(first).kind != JoiningSystem<kDim>::Source::kMap) ++first;
  for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
    const LocalMap<kDim>& map = set.graph.submaps[m];
    const LocalMap<kDim>& placed = *tests.system().maps()[m].map;  // with its features in another order
    const PartTest test = tests.leave_one_out->test({first + m, placed.row(placed.poses.size()), kDim});
    if (test.rows == 0) continue;
    const auto feature = std::ranges::find(map.features, placed.features.front()) - map.features.begin();
    const Eigen::Index row = map.row(map.poses.size() + static_cast<std::size_t>(feature));
    // The map without any information on this feature.
    SubmapSet<kDim> less = set;
    Eigen::MatrixXd& W = less.graph.submaps[m].information;
    const Eigen::MatrixXd W_f = W.middleCols(row, kDim);
    W -= W_f * Eigen::MatrixXd(W_f.middleRows(row, kDim)).inverse() * W_f.transpose();
    W.middleRows(row, kDim).setZero();
    W.middleCols(row, kDim).setZero();
    EXPECT_EQ(test.rows, kDim);
    EXPECT_NEAR(test.chi2, chi2 - run(less, options).value().chi2, 1e-3 * test.chi2 + 1e-9) << "map " << m;
    ++tested;
  }
  EXPECT_GT(tested, 1);
}

/// Tests whose chi2 are evenly spread quantiles, scaled.
std::vector<PartTest> spread_tests(int count, double scale) {
  std::vector<PartTest> tests;
  for (int k = 0; k < count; ++k) tests.push_back({scale * chi_squared_quantile((k + 0.5) / count, 3), 3, 3.0});
  return tests;
}

TEST(Scale, IsThatOfCautiousCovariancesWithAMargin) {
  const double scale = scale_of(spread_tests(400, 0.1), 3);
  EXPECT_GT(scale, 0.1);
  EXPECT_LT(scale, 0.13);
}

TEST(Scale, IsNeverAboveOne) {
  EXPECT_EQ(scale_of(spread_tests(400, 5.0), 3), 1.0);
}

TEST(Scale, IsOneOfAFewTests) {
  EXPECT_EQ(scale_of(spread_tests(19, 0.1), 3), 1.0);
  EXPECT_LT(scale_of(spread_tests(20, 0.1), 3), 1.0);
}

}  // namespace
}  // namespace mapjoin
