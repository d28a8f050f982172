// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tests/support/small_world.hpp>
#include <utility>

namespace mapjoin::testing {
namespace {

template <int Dim>
std::vector<Pose<Dim>> drive_round(int poses, const Pose<Dim>& start, Random& random) {
  std::vector<Pose<Dim>> path{start};
  while (static_cast<int>(path.size()) < poses) {
    Pose<Dim> step{random.vector<Dim>(0.1), Rotation<Dim>::exp(random.vector<kRotationDof<Dim>>(0.03))};
    step.translation[0] += 1.0;
    RotationVector<Dim> turn = RotationVector<Dim>::Zero();
    turn[kRotationDof<Dim> - 1] = 2.2 * std::numbers::pi / poses;
    step.rotation = step.rotation * Rotation<Dim>::exp(turn);
    path.push_back(compose(path.back(), step));
  }
  return path;
}

}  // namespace

template <int Dim>
Pose<Dim> noisy(const Pose<Dim>& pose, double noise, Random& random) {
  return retract(pose, PoseVector<Dim>(random.vector<kPoseDof<Dim>>(noise)));
}

template <int Dim>
void record(std::uint32_t session, const std::vector<Pose<Dim>>& path, const std::vector<Point<Dim>>& features,
            const WorldOptions& options, Random& random, LogBuilder<Dim>& builder) {
  const auto id = [&](std::size_t pose) { return PoseId{session, pose}; };
  const auto add_edge = [&](std::size_t base, std::size_t target) {
    builder.add_pose_edge(id(base), id(target), noisy(between(path[base], path[target]), options.noise, random),
                          1e3 * random.information<kPoseDof<Dim>>());
  };
  for (std::size_t pose = 0; pose < path.size(); ++pose) {
    builder.add_pose(id(pose));
    if (pose > 0) options.reversed_odometry&& pose % 3 == 0 ? add_edge(pose, pose - 1) : add_edge(pose - 1, pose);
    for (std::size_t f = 0; f < features.size(); ++f) {
      const Point<Dim> p_local = transform_into(path[pose], features[f]);
      if (p_local.norm() > options.range) continue;
      builder.add_observation(id(pose), {f}, p_local + random.vector<Dim>(options.noise), 1e3 * random.information<Dim>());
    }
  }
  const std::size_t half = path.size() / 2;
  for (std::size_t k = 0; k < static_cast<std::size_t>(options.closures); ++k) {
    const std::size_t early = 7 * k % half;
    const std::size_t late = half + 5 * k % half;
    k % 2 == 0 ? add_edge(late, early) : add_edge(early, late);
  }
}

template <int Dim>
SmallWorld<Dim> small_world(const WorldOptions& options) {
  Random random(options.seed);
  std::vector<std::vector<Pose<Dim>>> paths;
  for (int s = 0; s < options.sessions; ++s) {
    const Pose<Dim> start = s == 0 ? Pose<Dim>{} : random.pose<Dim>(1.5, 0.2);
    paths.push_back(drive_round<Dim>(options.poses, start, random));
  }
  std::vector<Point<Dim>> features;
  while (static_cast<int>(features.size()) < options.features) {
    const auto& path = paths[features.size() % paths.size()];
    const auto pose = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(path.size()) - 1.0));
    features.push_back(transform(path[pose], Point<Dim>(random.vector<Dim>(0.5 * options.range))));
  }
  LogBuilder<Dim> builder("small world");
  for (std::size_t s = 0; s < paths.size(); ++s) {
    record(static_cast<std::uint32_t>(s), paths[s], features, options, random, builder);
  }

  SmallWorld<Dim> world{std::move(builder).finish().value(), {}};
  for (const PoseId& id : world.log.poses) world.truth.poses.push_back(paths[id.session][id.key]);
  for (const FeatureId& id : world.log.features) world.truth.features.push_back(features[id.key]);
  return world;
}

template <int Dim>
double largest_difference(const Values<Dim>& a, const Values<Dim>& b) {
  if (a.poses.size() != b.poses.size() || a.features.size() != b.features.size()) return std::nan("");
  double largest = 0.0;
  for (const PoseIndex p : indices(a.poses)) largest = std::max(largest, local(a.poses[p], b.poses[p]).norm());
  for (const FeatureIndex f : indices(a.features)) {
    largest = std::max(largest, (a.features[f] - b.features[f]).norm());
  }
  return largest;
}

template Pose<2> noisy(const Pose<2>&, double, Random&);
template Pose<3> noisy(const Pose<3>&, double, Random&);
template void record(std::uint32_t, const std::vector<Pose<2>>&, const std::vector<Point<2>>&, const WorldOptions&, Random&,
                     LogBuilder<2>&);
template void record(std::uint32_t, const std::vector<Pose<3>>&, const std::vector<Point<3>>&, const WorldOptions&, Random&,
                     LogBuilder<3>&);
template SmallWorld<2> small_world<2>(const WorldOptions&);
template SmallWorld<3> small_world<3>(const WorldOptions&);
template double largest_difference(const Values<2>&, const Values<2>&);
template double largest_difference(const Values<3>&, const Values<3>&);

}  // namespace mapjoin::testing
