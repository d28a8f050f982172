// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Simulated worlds with closures, whose covariances are those of their noise.

#include <cstdlib>
#include <mapjoin/simulate/manhattan.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <utility>

namespace mapjoin::testing {

template <int Dim>
PoseVector<Dim> normal_step(RandomStream& random) {
  return PoseVector<Dim>::NullaryExpr([&] { return random.normal(); });
}

/// A simulated world with closures. Errors have the covariances that are stated.
template <int Dim>
struct ClosingWorld {
  ClosingWorld(std::int64_t poses, std::uint64_t seed, int closures = 8) : random(seed, 7) {
    ManhattanOptions options;
    options.poses = poses;
    options.seed = seed;
    auto simulation = simulate_manhattan<Dim>(options);
    log = std::move(simulation.log);
    truth = std::move(simulation.truth.poses);
    for (int k = 0; k < closures; ++k) add_closure();
  }
  PoseIndex any_pose() { return PoseIndex(static_cast<std::size_t>(random.next() % log.poses.size())); }
  void add_closure() {
    PoseIndex base = 0, target = 0;
    while (std::abs(target - base) < 2) base = any_pose(), target = any_pose();
    const Pose<Dim> true_step = between(truth[base], truth[target]);
    add(base, target, retract<Dim>(true_step, PoseVector<Dim>(0.05 * normal_step<Dim>(random))));
  }
  void add(PoseIndex base, PoseIndex target, const Pose<Dim>& measured) {
    log.graph.pose_factors.push_back({base, target, measured, PoseMatrix<Dim>::Identity() / (0.05 * 0.05)});
    put_in_order(log);
  }

  Log<Dim> log;
  Table<PoseIndex, Pose<Dim>> truth;
  RandomStream random;
};

}  // namespace mapjoin::testing
