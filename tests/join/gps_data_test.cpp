// SPDX-License-Identifier: BSD-3-Clause
// Victoria Park with the fixes of its receiver: their effect on the map, and the wrong ones among them.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/robust/fix_inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/measure/trajectory_error.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <set>
#include <tests/support/data.hpp>

namespace mapjoin::testing {
namespace {

constexpr double kDeviation = 1.0;  // (m): half of the fixes held out are within 0.92 m of the map
constexpr double kBlock = 30.0;     // (s): fixes are held out in stretches of this length
const Point<3> kLever(3.87, 0.47, 0.0);

class VictoriaParkGps : public ::testing::Test {
 protected:
  void SetUp() override {
    log_ = std::get<Log<2>>(open_log(data_file("vicpark-6898/vicpark_clean_data.txt.gz")).value());
    std::ifstream times(data_file("vicpark-6898/pose_times.txt"));
    std::int64_t first = 0;
    for (std::string line; std::getline(times, line);) {
      std::istringstream words(line);
      std::uint64_t pose = 0;
      if (words >> pose >> first) log_.stamps_ns.push_back(first * 1'000'000);
    }

    const auto file = data_file("vicpark-raw/aa3_gpsx.mat");
    const auto bytes = FileBytes::read(file).value();
    const auto mat = read_mat(bytes.view(), file, {"timeGps", "Lo_m", "La_m"}).value();
    const GeographicFrame park({-33.885, 151.19, 0.0});  // the file has metres; their place on Earth does not matter
    fixes_.source = file;
    for (Eigen::Index k = 0; k < mat.at("timeGps").size(); ++k) {
      const Point<3> local(mat.at("Lo_m")(k), mat.at("La_m")(k), 0.0);
      fixes_.fixes.push_back({static_cast<std::size_t>(k + 1), static_cast<std::int64_t>(1e6 * mat.at("timeGps")(k)),
                              std::nullopt, park.to_geographic(local), Vector<3>::Constant(kDeviation)});
    }
    attached_ = attach_fixes(fixes_, {.lever = kLever}, log_).value();
  }

  std::size_t block_of(std::size_t prior) const {
    const auto time = std::get<std::int64_t>(fixes_.fixes[attached_.lines[prior] - 1].when);
    return static_cast<std::size_t>(1e-9 * static_cast<double>(time) / kBlock);
  }
  /// The distance of the antenna from a fix, in a map that `frame` moves (m).
  double error(std::size_t prior, const GlobalMap<2>& map, const Pose<2>& frame = {}) const {
    const PoseFactor<2>& fix = log_.pose_priors()[prior];
    return (transform(frame, transform(map.poses[fix.target], fix.lever)) - fix.measured.translation).norm();
  }
  static std::set<std::size_t> wrong_in(const Log<2>& log) {
    std::set<std::size_t> wrong;
    const auto rejected = find_wrong_fixes(log, RobustOptions{}).value();
    for (const RejectedFix& fix : rejected) wrong.insert(fix.prior);
    return wrong;
  }

  Log<2> log_;
  GpsFixes fixes_;
  AttachedFixes attached_;
};

TEST_F(VictoriaParkGps, FixesThatAreHeldOutAreAsNearToTheMapAsWithoutAny) {
  Log<2> bare = log_;
  bare.graph.pose_factors.resize(bare.edges().size());
  const GlobalMap<2> without = run(bare, without_verdict()).value().map;
  constexpr std::size_t kFolds = 5;
  std::vector<double> errors_with, errors_without;
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    std::vector<RejectedFix> held_out;
    std::vector<Point<2>> antennas, measured;
    for (std::size_t f = 0; f < log_.pose_priors().size(); ++f) {
      if (block_of(f) % kFolds == fold) held_out.push_back({f, 0.0, 1.0});
    }
    Log<2> rest = without_fixes(log_, held_out);
    rest = without_fixes(rest, find_wrong_fixes(rest, RobustOptions{}).value());
    for (const PoseFactor<2>& fix : rest.pose_priors()) {
      antennas.push_back(transform(without.poses[fix.target], fix.lever));
      measured.push_back(fix.measured.translation);
    }
    const Pose<2> frame = align<2>(antennas, measured);
    const GlobalMap<2> with = run(rest, without_verdict()).value().map;
    for (const RejectedFix& fix : held_out) {
      errors_with.push_back(error(fix.prior, with));
      errors_without.push_back(error(fix.prior, without, frame));
    }
  }
  const double with = median(errors_with);
  std::cout << "held-out fixes " << errors_with.size() << ": median error " << with << " m with the others, "
            << median(errors_without) << " m without\n";
  EXPECT_LE(with, 0.92);
  EXPECT_LE(with, median(errors_without));
}

TEST_F(VictoriaParkGps, FixesThatAreMovedAreNamed) {
  const std::set<std::size_t> wrong_before = wrong_in(log_);
  RandomStream random(1, 0);
  std::set<std::size_t> moved;
  Log<2> spoiled = log_;
  for (std::size_t f = 0; f < log_.pose_priors().size(); ++f) {
    if (random.uniform(0.0, 1.0) >= 0.2) continue;
    const double angle = random.uniform(0.0, 6.28), distance = random.uniform(10.0, 60.0);
    auto& fix = spoiled.graph.pose_factors[log_.edges().size() + f];
    fix.measured.translation += distance * Point<2>(std::cos(angle), std::sin(angle));
    moved.insert(f);
  }
  const std::set<std::size_t> named = wrong_in(spoiled);
  std::size_t right = 0, named_wrongly = 0;
  for (const std::size_t f : named) {
    if (moved.contains(f)) {
      ++right;
    } else if (!wrong_before.contains(f)) {
      ++named_wrongly;  // fixes that are wrong in the file itself are rightly named
    }
  }
  const double precision = static_cast<double>(right) / static_cast<double>(right + named_wrongly);
  const double recall = static_cast<double>(right) / static_cast<double>(moved.size());
  std::cout << log_.pose_priors().size() << " fixes, " << wrong_before.size() << " wrong as the file has them, " << moved.size()
            << " moved: precision " << precision << ", recall " << recall << "\n";
  EXPECT_GE(precision, 0.95);
  EXPECT_GE(recall, 0.95);
}

}  // namespace
}  // namespace mapjoin::testing
