// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <numbers>

namespace mapjoin {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;
/// The least number of loops or turns that prove anything.
constexpr std::size_t kLeastSamples = 10;

void warn(Findings& findings, std::string text, Places where = {}) {
  findings.push_back({FindingLevel::kWarning, "degrees", std::move(text), std::move(where)});
}

void check_range(const Log<2>& log, Findings& findings) {
  Places unwrapped;
  Places beyond;
  double largest = 0.0;
  for (const PoseFactor<2>& edge : log.edges()) {
    const double turn = std::abs(edge.measured.rotation.angle());
    largest = std::max(largest, turn);
    if (turn <= kPi + 1e-6) continue;
    (turn > 2.0 * kPi + 1e-6 ? beyond : unwrapped)
        .add(fmt::format("{} to {}", to_string(log.poses[edge.base]), to_string(log.poses[edge.target])));
  }
  // A few may be right: robots that spun round unseen.
  if (100 * beyond.count > log.edges().size()) {
    warn(findings,
         fmt::format("{} beyond a full turn, up to {:.6g}: in degrees?", plural(beyond.count, "relative heading"), largest),
         beyond);
  }
  add_if_any(findings, {FindingLevel::kNote, "unwrapped",
                        fmt::format("{} beyond a half turn, up to {:.6g} rad: not wrapped",
                                    plural(unwrapped.count, "relative heading"), largest),
                        unwrapped});
}

/// The steps of odometry by the pose that they start from, in driving direction; NaN if there is none.
Table<PoseIndex, Pose<2>> steps_of(const Log<2>& log) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Table<PoseIndex, Pose<2>> steps(log.poses.size(), Pose<2>{Point<2>::Constant(kNone), Rotation<2>(kNone)});
  for (const PoseFactor<2>& edge : log.odometry()) {
    const bool is_forward = edge.base < edge.target;
    steps[std::min(edge.base, edge.target)] = is_forward ? edge.measured : inverse(edge.measured);
  }
  return steps;
}

/// Closing errors of short loops, with headings as they are and taken as degrees; only of loops for which this makes a
/// difference.
struct Misses {
  std::vector<double> as_given;
  std::vector<double> as_degrees;
};

/// Adds the closing error of a point seen at pose `first` and once more at pose `last`, a few steps later.
void add_miss(const Table<PoseIndex, Pose<2>>& steps, PoseIndex first, PoseIndex last, const Point<2>& seen_first,
              Point<2> seen_last, Misses& misses) {
  Point<2> by_degrees = seen_last;
  double size = seen_first.norm() + seen_last.norm();
  for (PoseIndex pose = last; pose > first; --pose) {
    const Pose<2>& step = steps[pose - 1];
    seen_last = transform(step, seen_last);
    by_degrees = transform(Pose<2>{step.translation, Rotation<2>(kDegree * step.rotation.angle())}, by_degrees);
    size += step.translation.norm();
  }
  constexpr double kNoticeable = 0.05;
  if (!((seen_last - by_degrees).norm() > kNoticeable * size)) return;  // Also if a step is missing (NaN).
  misses.as_given.push_back((seen_last - seen_first).norm());
  misses.as_degrees.push_back((by_degrees - seen_first).norm());
}

/// Closing errors of features seen again after a few steps, and of closures over a few steps.
Misses short_loops(const Log<2>& log) {
  constexpr int kMostSteps = 10;
  const Table<PoseIndex, Pose<2>> steps = steps_of(log);
  Misses misses;
  Table<FeatureIndex, const FeatureFactor<2>*> last_seen(log.features.size());
  for (const FeatureFactor<2>& seen : log.observations()) {
    auto& before = last_seen[seen.target];
    if (before && seen.base > before->base && seen.base - before->base <= kMostSteps) {
      add_miss(steps, before->base, seen.base, before->measured, seen.measured, misses);
    }
    before = &seen;
  }
  for (const PoseFactor<2>& closure : log.closures()) {
    if (std::abs(closure.target - closure.base) > kMostSteps) continue;
    const bool is_forward = closure.base < closure.target;
    const Point<2> end = is_forward ? closure.measured.translation : inverse(closure.measured).translation;
    add_miss(steps, std::min(closure.base, closure.target), std::max(closure.base, closure.target), end, Point<2>::Zero(),
             misses);
  }
  return misses;
}

void check_loops(const Log<2>& log, Findings& findings) {
  constexpr double kBetter = 3.0;
  const Misses misses = short_loops(log);
  const std::size_t loops = misses.as_given.size();
  if (loops < kLeastSamples) return;
  const double as_given = median(misses.as_given);
  const double as_degrees = median(misses.as_degrees);
  if (kBetter * as_degrees > as_given) return;
  warn(findings, fmt::format("{} short loops miss their beginning by {:.3g} m (median), by {:.3g} m with headings as degrees",
                             loops, as_given, as_degrees));
}

void check_values(const Log<2>& log, Findings& findings) {
  constexpr double kLeastTurn = 0.05;
  constexpr double kTolerance = 0.1;
  if (log.initial.poses.empty()) return;
  const auto heading = [&](PoseIndex p) { return log.initial.poses[p].rotation.angle(); };
  std::vector<double> ratios;
  for (const PoseFactor<2>& edge : log.odometry()) {
    const double turned = heading(edge.target) - heading(edge.base);
    const double measured = edge.measured.rotation.angle();
    if (std::min(std::abs(turned), std::abs(measured)) * (180.0 / kPi) < kLeastTurn) continue;
    if (std::max(std::abs(turned), std::abs(measured)) > kLeastTurn) ratios.push_back(turned / measured);
  }
  if (ratios.size() < kLeastSamples) return;
  const double ratio = median(ratios);
  if (std::abs(ratio * kDegree - 1.0) < kTolerance) {
    warn(findings, fmt::format("the values turn {:.3g} times as much as the edges: their headings are in degrees", ratio));
  } else if (std::abs(ratio / kDegree - 1.0) < kTolerance) {
    warn(findings,
         fmt::format("the edges turn {:.3g} times as much as the values: their headings are in degrees", 1.0 / ratio));
  }
}

void check_uncertainty(const Log<2>& log, Findings& findings) {
  std::vector<double> deviations;
  for (const PoseFactor<2>& edge : log.odometry()) {
    if (edge.information(2, 2) > 0.0) deviations.push_back(1.0 / std::sqrt(edge.information(2, 2)));
  }
  if (deviations.size() < kLeastSamples) return;
  const double middle = median(deviations);
  if (middle < 0.5 * kPi) return;
  warn(findings, fmt::format("the headings of odometry have a standard deviation of {:.3g} rad (median): in degrees?", middle));
}

}  // namespace

template <>
Findings check_units(const Log<2>& log) {
  if (!check_invariants(log)) return {};
  Findings findings;
  check_range(log, findings);
  check_loops(log, findings);
  check_values(log, findings);
  check_uncertainty(log, findings);
  return findings;
}

template <>
Findings check_units(const Log<3>&) {
  return {};
}

}  // namespace mapjoin
