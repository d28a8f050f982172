// SPDX-License-Identifier: BSD-3-Clause
// Robust joining of logs: public ones, clean and with wrong closures planted into them, and those of data/cases.
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <set>
#include <tests/support/data.hpp>
#include <tests/support/places.hpp>

namespace mapjoin {
namespace {

using ::testing::TestWithParam;

template <int Dim = 2>
Log<Dim> log_in(const std::filesystem::path& file) {
  return std::get<Log<Dim>>(open_log(file).value());
}

template <int Dim>
std::size_t rejected_of(const Log<Dim>& log) {
  return find_inliers(log, RobustOptions{}).value().rejected.size();
}

/// A public log whose measurements all belong to it.
class CleanLogData : public TestWithParam<const char*> {};

TEST_P(CleanLogData, LosesNothing) {
  EXPECT_EQ(rejected_of(log_in(testing::data_file(GetParam()))), 0U);
}
INSTANTIATE_TEST_SUITE_P(Robust, CleanLogData,
                         ::testing::Values("pose-graphs-2d/intel.g2o.gz", "pose-graphs-2d/manhattanOlson3500.g2o.gz",
                                           "pose-graphs-2d/CSAIL.g2o.gz", "pose-graphs-2d/MIT.g2o.gz"));

/// The numbers of closures rejected and kept from a log with wrong ones planted. A planted one that is kept counts only if it
/// is more than 10 standard deviations from what the map of the clean log predicts.
struct Score {
  std::size_t right_rejected = 0;
  std::size_t wrong_rejected = 0;
  std::size_t wrong_kept = 0;

  double precision() const {
    return static_cast<double>(wrong_rejected) / static_cast<double>(wrong_rejected + right_rejected);
  }
  double recall() const { return static_cast<double>(wrong_rejected) / static_cast<double>(wrong_rejected + wrong_kept); }
};

template <int Dim>
class PlantedClosures {
 public:
  PlantedClosures(const Log<Dim>& log, ClosurePolicy policy, double share, std::uint64_t seed = 1)
      : planted_(planted_into(log, policy, share, seed)) {
    RunOptions options = without_verdict();
    options.covariances = true;
    clean_ = run(log, options).value();
  }

  Score score() const {
    std::set<std::pair<PoseIndex, PoseIndex>> kept;
    const auto inliers = find_inliers(planted_.log, RobustOptions{}).value();
    for (const auto& o : inliers.input.closures()) kept.emplace(o.base, o.target);
    Score score;
    const auto closures = planted_.log.closures();
    for (std::size_t k = 0; k < closures.size(); ++k) {
      const bool is_kept = kept.contains({closures[k].base, closures[k].target});
      if (!planted_.is_wrong[k]) {
        score.right_rejected += is_kept ? 0 : 1;
      } else if (!is_kept) {
        ++score.wrong_rejected;
      } else if (is_far(closures[k])) {
        ++score.wrong_kept;
      }
    }
    return score;
  }

 private:
  static Planted<Dim> planted_into(const Log<Dim>& log, ClosurePolicy policy, double share, std::uint64_t seed) {
    const auto own = static_cast<double>(log.closures().size());
    return plant_wrong_closures(log, policy, static_cast<std::size_t>(own * share / (1.0 - share)), seed);
  }
  bool is_far(const PoseFactor<Dim>& o) const {
    const auto r = residual<Dim>(o.measured, clean_.map.poses[o.base], clean_.map.poses[o.target]);
    const PoseMatrix<Dim> S = o.information.inverse() + clean_.covariances->relative_pose(o.base, o.target).value();
    return r.dot(S.inverse() * r) > 10.0 * 10.0;
  }

  Planted<Dim> planted_;
  RunResult<Dim> clean_;
};

struct Planting {
  const char* file;
  ClosurePolicy policy;
  double share;  ///< Share of wrong closures among all.
};
class PlantedClosuresData : public TestWithParam<Planting> {};

TEST_P(PlantedClosuresData, AreRejectedAndHardlyAnyOther) {
  const auto& [file, policy, share] = GetParam();
  const Score score = PlantedClosures(log_in(testing::data_file(file)), policy, share).score();
  EXPECT_GE(score.recall(), 0.99);
  EXPECT_GE(score.precision(), 0.9995);
}
INSTANTIATE_TEST_SUITE_P(Robust, PlantedClosuresData,
                         ::testing::Values(Planting{"pose-graphs-2d/intel.g2o.gz", ClosurePolicy::kRandom, 0.5},
                                           Planting{"pose-graphs-2d/intel.g2o.gz", ClosurePolicy::kRandomGroups, 0.5},
                                           Planting{"pose-graphs-2d/manhattanOlson3500.g2o.gz", ClosurePolicy::kRandom, 0.7},
                                           Planting{"pose-graphs-2d/manhattanOlson3500.g2o.gz", ClosurePolicy::kRandomGroups,
                                                    0.5}));

/// Groups of wrong closures bear each other out: a first map of all that are likely would be of wrong ones.
TEST(PlantedGroupsData, AreFoundWhereOneOfTenIsRight) {
  const auto log = log_in(testing::data_file("pose-graphs-2d/manhattanOlson3500.g2o.gz"));
  const Score score = PlantedClosures(log, ClosurePolicy::kRandomGroups, 0.9, 2).score();
  EXPECT_GE(score.recall(), 0.9995);
  EXPECT_GE(score.precision(), 0.9995);
}

/// Wrong groups are kept in the first maps that bend the map, and right closures rejected that outnumber them.
TEST(PlantedGroupsData, GiveWayWhereTheyAreOutnumbered) {
  const auto log = log_in<3>(testing::data_file("pose-graphs-3d/sphere2500.g2o.gz"));
  const Score score = PlantedClosures(log, ClosurePolicy::kRandomGroups, 0.9, 3).score();
  EXPECT_EQ(score.wrong_kept, 0U);
  EXPECT_EQ(score.right_rejected, 0U);
}

/// Right closures fit a thousand times as closely as covariances say, and three of four wrong ones are within these.
TEST(PlantedClosures3DData, AreFoundThoughMostAreNear) {
  const auto log = log_in<3>(testing::data_file("pose-graphs-3d/parking-garage.g2o.gz"));
  const Score score = PlantedClosures(log, ClosurePolicy::kRandom, 0.1).score();
  EXPECT_EQ(score.wrong_kept, 0U);
  EXPECT_EQ(score.right_rejected, 0U);
}

/// A wrong group passes each test with covariances as cautious as those of Intel, but does not fit as closely as loops say that
/// right closures do.
TEST(PlantedGroupsData, AreFoundWhereTheLogPassesItsTestsWithThem) {
  const Score score =
      PlantedClosures(log_in(testing::data_file("pose-graphs-2d/intel.g2o.gz")), ClosurePolicy::kRandomGroups, 0.0064, 3)
          .score();
  EXPECT_EQ(score.wrong_rejected, 5U);
  EXPECT_EQ(score.right_rejected, 0U);
}

/// MIT has twenty closures, of which odds tell little: the first map that leads to all of them differs from draw to draw. Each
/// of these draws has a first map that does not.
class FewClosuresData : public TestWithParam<std::uint64_t> {};

TEST_P(FewClosuresData, AreAllKeptWhereAsManyAreWrong) {
  const Score score =
      PlantedClosures(log_in(testing::data_file("pose-graphs-2d/MIT.g2o.gz")), ClosurePolicy::kRandom, 0.5, GetParam()).score();
  EXPECT_EQ(score.wrong_kept, 0U);
  EXPECT_EQ(score.right_rejected, 0U);
}
INSTANTIATE_TEST_SUITE_P(Seeds, FewClosuresData, ::testing::Values(1, 6, 7, 8, 9));

/// Small logs with wrong closures, with which full SLAM finds no map that fits.
class RobustCases : public TestWithParam<const char*> {};

TEST_P(RobustCases, FitOnceTheWrongClosuresAreOut) {
  const auto fit_without_outliers = [](const auto& log) {
    EXPECT_EQ(run(log, {}).value().fit.verdict, Verdict::kMisfit);
    const auto inliers = find_inliers(log, RobustOptions{}).value();
    EXPECT_LE(inliers.rejected.size(), 3U);
    EXPECT_EQ(run(inliers.input, {}).value().fit.verdict, Verdict::kFits);
  };
  std::visit(fit_without_outliers, open_log(testing::kBundledData / "cases" / GetParam()).value());
}
INSTANTIATE_TEST_SUITE_P(Cases, RobustCases, ::testing::Values("A_1900.g2o", "A_2442.g2o"));

TEST(RobustData, AWrongClosureOfHugeInformationIsTheOneThatIsRejected) {
  Log<2> log = log_in(testing::data_file("dlr/dlr_corrected.g2o.gz"));
  const IndexOf index_of(log.poses);
  const PoseIndex base = index_of({0, 1291}).value();
  const PoseIndex target = index_of({0, 1739}).value();
  log.graph.pose_factors.push_back({base, target, {{0.00194, -0.1501}, Rotation<2>(0.04944)}, 5e4 * Matrix<3>::Identity()});
  put_in_order(log);
  const auto rejected = find_inliers(log, RobustOptions{}).value().rejected;
  ASSERT_FALSE(rejected.empty());
  EXPECT_EQ(rejected[0].misfit.kind, PartKind::kClosure);
  EXPECT_EQ(rejected[0].misfit.from, base);
  EXPECT_EQ(rejected[0].misfit.to, PoseOrFeature(target));
  EXPECT_LT(rejected[0].misfit.probability, 1e-6);
}

}  // namespace
}  // namespace mapjoin
