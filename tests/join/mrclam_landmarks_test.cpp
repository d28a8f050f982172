// SPDX-License-Identifier: BSD-3-Clause
// The landmarks of MRCLAM 6, most of them 0.18 m from the next one, told apart by range and bearing alone while all else is
// known: a bound for any association without barcodes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <mapjoin/io/mrclam/team.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <numbers>
#include <tests/support/data.hpp>
#include <tests/support/motion_capture.hpp>
#include <tests/support/pair_score.hpp>

namespace mapjoin::testing {
namespace {

using Landmarks = std::map<std::uint64_t, Point<2>>;  // by subject

Landmarks surveyed(const std::filesystem::path& file) {
  const auto bytes = FileBytes::read(file).value();
  Landmarks landmarks;
  for (TextScanner text(file.string(), bytes.view()); text.next_line();) {
    const auto subject = text.key();
    landmarks[subject] = text.vector<4>().head<2>();
  }
  return landmarks;
}

/// A sighting of a landmark from a pose that motion capture saw.
struct Seen {
  std::uint64_t landmark = 0;
  Pose<2> from;
  Point<2> measured;  // range (m) and bearing (rad)
};

std::vector<Seen> sightings_of(const mrclam::Team& team, std::uint64_t robot, const Trajectory& truth) {
  std::vector<Seen> sightings;
  for (const auto& seen : team.robots.at(robot).sightings) {
    const auto subject = team.subjects.find(seen.barcode);
    const auto pose = truth.lower_bound(seen.time);
    if (pose == truth.end() || subject == team.subjects.end() || !mrclam::is_landmark(subject->second)) continue;
    sightings.push_back({subject->second, pose->second, {seen.range, seen.bearing}});
  }
  return sightings;
}

/// The measured range and bearing less those of a landmark (m, rad).
Point<2> residual(const Seen& seen, const Point<2>& landmark) {
  const Point<2> p = seen.from.rotation.matrix().transpose() * (landmark - seen.from.translation);
  return {seen.measured[0] - p.norm(), std::remainder(seen.measured[1] - std::atan2(p.y(), p.x()), 2.0 * std::numbers::pi)};
}

/// The bias and the standard deviation of range and bearing (m, rad), by medians, for barcodes may be misread.
struct Noise {
  Point<2> bias;
  Point<2> deviation;
};

Noise noise_of(const std::vector<Seen>& sightings, const Landmarks& landmarks) {
  Noise noise;
  for (const int k : {0, 1}) {
    std::vector<double> residuals;
    for (const Seen& seen : sightings) residuals.push_back(residual(seen, landmarks.at(seen.landmark))[k]);
    noise.bias[k] = median(residuals);
    for (double& r : residuals) r = std::abs(r - noise.bias[k]);
    noise.deviation[k] = 1.4826 * median(residuals);  // the standard deviation of a normal distribution
  }
  return noise;
}

/// The score of associating each sighting with the landmark whose residual is the most likely.
PairScore score_of_most_likely(const std::vector<Seen>& sightings, const Landmarks& landmarks) {
  const Noise noise = noise_of(sightings, landmarks);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> pairs;
  for (const Seen& seen : sightings) {
    const auto distance = [&](const auto& landmark) {
      return (residual(seen, landmark.second) - noise.bias).cwiseQuotient(noise.deviation).squaredNorm();
    };
    pairs.emplace_back(seen.landmark, std::ranges::min_element(landmarks, {}, distance)->first);
  }
  return pair_score(pairs);
}

TEST(MrclamLandmarks, AreNotToldApartWellByRangeAndBearingEvenWhereAllElseIsKnown) {
  const auto data = data_file("mrclam6");
  const auto team = mrclam::read_team(data).value();
  const Landmarks landmarks = surveyed(data / "Landmark_Groundtruth.dat");
  for (const auto& [robot, files] : team.robots) {
    const auto truth = motion_capture(data / fmt::format("Robot{}_Groundtruth.dat.gz", robot));
    const PairScore score = score_of_most_likely(sightings_of(team, robot, truth), landmarks);
    std::cout << fmt::format("robot {}: precision {:.3f}, recall {:.3f}\n", robot, score.precision, score.recall);
    EXPECT_LT(score.precision, 0.97) << robot;
    EXPECT_LT(score.recall, 0.97) << robot;
    EXPECT_GT(score.recall, 0.8) << robot;
  }
}

}  // namespace
}  // namespace mapjoin::testing
