// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A small world as a join of local maps, or of single observations, at its composed start.

#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/small_world.hpp>
#include <utility>

namespace mapjoin::testing {

template <int Dim>
struct PosedWorld {
  explicit PosedWorld(Log<Dim> the_log, double poses_per_map = 1.0)
      : log(std::move(the_log)),
        parts(split(log, {SplitRule::kPoses, poses_per_map})),
        graph(submap_graph_of(log, parts, build_local_maps<Dim>(log, parts, {}).value().maps)),
        composed(std::move(join_segments(graph, {Schedule::kBatch, JoinedState::kAbsolute, {}}).partials.front())),
        problem(composed, {{0}, {}}) {}
  PosedWorld(const PosedWorld&) = delete;
  PosedWorld& operator=(const PosedWorld&) = delete;

  const JoiningSystem<Dim>& system() { return problem; }
  const Values<Dim>& state() { return problem.estimate(); }
  /// A state with each coordinate moved by at most `radius` (m, rad), but for pose 0, which is held.
  Values<Dim> moved_by(double radius, unsigned seed = 5) {
    Random random(seed);
    Values<Dim> moved = state();
    for (PoseIndex p = 1; p < indices(moved.poses).last; ++p) {
      moved.poses[p] = retract<Dim>(moved.poses[p], random.vector<kPoseDof<Dim>>(radius));
    }
    for (auto& feature : moved.features) feature += random.vector<Dim>(radius);
    return moved;
  }

  Log<Dim> log;
  Split parts;
  SubmapGraph<Dim> graph;
  PartialMap<Dim> composed;
  JoiningSystem<Dim> problem;
};

/// A walk all relations of which are in the relative state: each pose is observed from the one before, twice, with another
/// translation the second time, and each feature from one pose. Every third step may be stored against its direction.
template <int Dim>
Log<Dim> tree_world(bool reversed_odometry = false) {
  Random random(3);
  LogBuilder<Dim> builder("tree world");
  for (std::uint64_t pose = 0; pose < 30; ++pose) {
    Pose<Dim> step = random.pose<Dim>(1.0, 1.5);
    const auto add = [&] {
      const auto information = random.information<kPoseDof<Dim>>();
      reversed_odometry&& pose % 3 == 2 ? builder.add_pose_edge({0, pose + 1}, {0, pose}, step, information)
                                        : builder.add_pose_edge({0, pose}, {0, pose + 1}, step, information);
    };
    add();
    step.translation += random.vector<Dim>(0.2);
    add();
    builder.add_observation({0, pose}, {pose}, random.vector<Dim>(3.0), random.information<Dim>());
  }
  return std::move(builder).finish().value();
}

}  // namespace mapjoin::testing
