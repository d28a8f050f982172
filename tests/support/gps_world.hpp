// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Simulated drives with a satellite receiver whose antenna stands away from the pose.

#include <mapjoin/simulate/manhattan.hpp>
#include <mapjoin/simulate/random_stream.hpp>

namespace mapjoin::testing {

struct GpsWorldOptions {
  std::int64_t poses = 200;
  std::int32_t between = 5;  ///< Number of poses from one fix to the next.
  double deviation = 0.4;    ///< Standard deviation of each coordinate of a fix (m).
  std::uint64_t seed = 1;
};

template <int Dim>
struct GpsWorld {
  Log<Dim> log;       ///< A log whose pose priors are the fixes; nothing is fixed.
  Values<Dim> truth;  ///< The truth in the frame of the fixes.
  Point<Dim> lever;   ///< The antenna in the frame of a pose (m).
};

template <int Dim>
GpsWorld<Dim> gps_world(const GpsWorldOptions& options = {}) {
  auto simulation = simulate_manhattan<Dim>({.poses = options.poses, .seed = options.seed});
  RandomStream random(options.seed, 1);
  Pose<Dim> frame;
  RotationVector<Dim> turn;
  for (int i = 0; i < Dim; ++i) frame.translation[i] = random.uniform(-100.0, 100.0);
  for (int i = 0; i < kRotationDof<Dim>; ++i) turn[i] = random.uniform(-1.5, 1.5);
  frame.rotation = Rotation<Dim>::exp(turn);
  GpsWorld<Dim> world{std::move(simulation.log), moved(frame, Values<Dim>{simulation.truth.poses, simulation.truth.features}),
                      Point<Dim>::Zero()};
  world.lever[0] = 3.8;
  world.lever[1] = 0.5;
  world.log.graph.fixed.clear();
  for (const PoseIndex p : indices(world.truth.poses)) {
    if (p.value % options.between != 0) continue;
    PoseFactor<Dim> fix{kWorld, p, {}, PoseMatrix<Dim>::Zero(), {}, world.lever};
    fix.measured.translation = transform(world.truth.poses[p], world.lever);
    for (int i = 0; i < Dim; ++i) fix.measured.translation[i] += options.deviation * random.normal();
    fix.information.template topLeftCorner<Dim, Dim>() = PointMatrix<Dim>::Identity() / (options.deviation * options.deviation);
    world.log.graph.pose_factors.push_back(fix);
  }
  return world;
}

}  // namespace mapjoin::testing
