// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <numbers>

namespace mapjoin {
namespace {

template <int Dim>
Eigen::AlignedBox<double, Dim> bounding_box(const Values<Dim>& state) {
  Eigen::AlignedBox<double, Dim> box;
  for (const auto& pose : state.poses) box.extend(pose.translation);
  for (const auto& feature : state.features) box.extend(feature);
  return box;
}

template <int Dim>
Point<Dim> random_point(const Eigen::AlignedBox<double, Dim>& box, RandomStream& random) {
  Point<Dim> point;
  for (int i = 0; i < Dim; ++i) point[i] = random.uniform(box.min()[i], box.max()[i]);
  return point;
}

template <int Dim>
Rotation<Dim> random_rotation(RandomStream& random) {
  if constexpr (Dim == 2) {
    return Rotation<2>(random.uniform(-std::numbers::pi, std::numbers::pi));
  } else {
    Eigen::Vector4d direction;  // direction of a normal vector: uniform on the sphere of unit quaternions
    for (int i = 0; i < 4; ++i) direction[i] = random.normal();
    return Rotation<3>(Eigen::Quaterniond(direction.normalized()));
  }
}

}  // namespace

template <int Dim>
void set_to_zero(PartialMap<Dim>& partial) {
  std::fill(partial.state.poses.begin() + 1, partial.state.poses.end(), Pose<Dim>{});
  std::fill(partial.state.features.begin(), partial.state.features.end(), Point<Dim>::Zero());
}

template <int Dim>
void set_to_random(std::uint64_t seed, PartialMap<Dim>& partial) {
  const auto box = bounding_box(partial.state);
  RandomStream random(seed, 0);
  for (auto pose = partial.state.poses.begin() + 1; pose != partial.state.poses.end(); ++pose) {
    pose->translation = random_point<Dim>(box, random);
    pose->rotation = random_rotation<Dim>(random);
  }
  for (auto& feature : partial.state.features) feature = random_point<Dim>(box, random);
}

template <int Dim>
void set_to_values(const Values<Dim>& state, PartialMap<Dim>& partial) {
  for (const PoseIndex p : indices(partial.poses)) partial.state.poses[p] = state.pose(partial.poses[p]);
  for (const FeatureIndex f : indices(partial.features)) partial.state.features[f] = state.features[partial.features[f]];
}

template <int Dim>
void set_start(Start start, std::uint64_t seed, const Values<Dim>* values, PartialMap<Dim>& partial) {
  if (start == Start::kZero) set_to_zero(partial);
  if (start == Start::kRandom) set_to_random(seed, partial);
  if (start == Start::kFile) set_to_values(*values, partial);
}

#define MAPJOIN_INSTANTIATE(Dim)                                     \
  template void set_to_zero(PartialMap<Dim>&);                       \
  template void set_to_random(std::uint64_t, PartialMap<Dim>&);      \
  template void set_to_values(const Values<Dim>&, PartialMap<Dim>&); \
  template void set_start(Start, std::uint64_t, const Values<Dim>*, PartialMap<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
