// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Simulated logs with their truth: a robot in the streets of Manhattan, or in the corridors and shafts of a building.

#include <cstdint>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <numbers>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

/// The robot walks `step` at a time along a lattice of corners `block` apart, straight on with probability 1/2 at a corner,
/// else turning on the spot; a step's relative pose is forward, then that turn. There is one feature a cell, anywhere; the
/// robot sees those in range all around it.
struct ManhattanOptions {
  std::int64_t poses = 1000;  ///< At most kMostPoses.
  std::uint64_t seed = 1;     ///< The same seed and options give the same log.
  std::int64_t part = 1;      ///< Of `parts`, which have as many poses each but for one. An edge is of the part of its later
  std::int64_t parts = 1;     ///< pose. Features of a part have the ids that they have in a g2o file of the whole log.

  double step = 1.0;   ///< (m)
  double block = 5.0;  ///< (m), a multiple of `step`.
  std::optional<double> side =
      std::nullopt;          ///< Of the square that the walk stays in (m); 2 √(poses/5) if not given, one block at least.
  std::int64_t storeys = 3;  ///< Levels one block apart; in space only.

  double feature_cell = 2.0;    ///< One feature in every square (cube) of this side (m),
  double feature_jitter = 0.3;  ///< off its centre by at most so much along every axis (m).
  double range = 3.0;           ///< Of the sensor (m).
  double chance = 1.0;          ///< Of a feature in range to be seen.

  double step_noise = 0.03;                            ///< Standard deviation along every axis of a step (m).
  double turn_noise = 0.4 * std::numbers::pi / 180.0;  ///< Standard deviation about every axis of a step (rad).
  double observation_noise = 0.07;                     ///< Standard deviation along every axis of an observation (m).
  double noise_multiplier = 1.0;  ///< The errors made, by the ones stated: 0 makes a log without errors, 1 a consistent one.

  static constexpr std::int64_t kMostPoses = 10'000'000;

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

template <int Dim>
struct Simulation {
  Log<Dim> log;          ///< Features are those that were seen, named in the order in which they were; pose 0 is fixed.
  GlobalMap<Dim> truth;  ///< Pose 0 is the origin. Over the poses and features of the log.
};

/// In space the lattice has `storeys` levels, a turn is left, right, up or down, and roll, pitch and yaw all occur. Time and
/// memory are linear in poses and observations. In the plane the same bits everywhere; in space but for the last digits of the
/// C library's sine. Once a stop is requested the walk ends, of fewer poses. Throws std::invalid_argument with the violations
/// of `options`.
template <int Dim>
Simulation<Dim> simulate_manhattan(const ManhattanOptions& options, const std::stop_token& stop = {});

}  // namespace mapjoin
