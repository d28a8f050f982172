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

/// Options of the simulation. The robot walks `step` at a time along a lattice of corners `block` apart; at a corner it goes
/// straight on with probability 1/2 and otherwise turns on the spot. A step's relative pose is forward, then that turn. Every
/// cell has one feature; the robot sees those in range all around it.
struct ManhattanOptions {
  std::int64_t poses = 1000;  ///< At most kMostPoses.
  std::uint64_t seed = 1;     ///< The same seed and options give the same log.
  std::int64_t part = 1;      ///< The part to simulate, from 1. An edge belongs to the part of its later pose.
  std::int64_t parts = 1;     ///< Number of parts, equal to within one pose; feature ids are as in a g2o file of all.

  double step = 1.0;   ///< (m)
  double block = 5.0;  ///< (m), a multiple of `step`.
  std::optional<double> side =
      std::nullopt;  ///< Side of the square that the walk stays in (m), one block at least; 2 √(poses/5) if not given.
  std::int64_t storeys = 3;  ///< Levels one block apart; in space only.

  double feature_cell = 2.0;    ///< Side of the squares (cubes) that hold one feature each (m).
  double feature_jitter = 0.3;  ///< The largest offset of a feature from the centre of its cell, along every axis (m).
  double range = 3.0;           ///< Range of the sensor (m).
  double chance = 1.0;          ///< Probability that a feature in range is seen.

  double step_noise = 0.03;                            ///< Standard deviation along every axis of a step (m).
  double turn_noise = 0.4 * std::numbers::pi / 180.0;  ///< Standard deviation about every axis of a step (rad).
  double observation_noise = 0.07;                     ///< Standard deviation along every axis of an observation (m).
  double noise_multiplier = 1.0;  ///< Ratio of actual to stated errors: 0 makes a log without errors, 1 a consistent one.

  static constexpr std::int64_t kMostPoses = 10'000'000;

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

template <int Dim>
struct Simulation {
  Log<Dim> log;          ///< Its features are those seen, named in the order of first sight. Pose 0 is fixed.
  GlobalMap<Dim> truth;  ///< The true poses and features of the log; pose 0 is the origin.
};

/// Simulates a log and its truth. In space the lattice has `storeys` levels, a turn is left, right, up or down, and roll, pitch
/// and yaw all occur. Time and memory are linear in poses and observations. The result is the same to the bit on every machine
/// in the plane; in space it may differ in the last digits of the C library's sine. A stop request ends the walk early, with
/// fewer poses. Throws std::invalid_argument with the violations of `options`.
template <int Dim>
Simulation<Dim> simulate_manhattan(const ManhattanOptions& options, const std::stop_token& stop = {});

}  // namespace mapjoin
