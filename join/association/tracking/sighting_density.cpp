// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <mapjoin/join/association/tracking/sighting_density.hpp>
#include <mapjoin/model/information.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The points that every pose or local map sees at once.
template <int Dim>
std::vector<std::vector<Point<Dim>>> seen_at_once(std::span<const FeatureFactor<Dim>> observations,
                                                  const std::vector<LocalMap<Dim>>& maps) {
  std::vector<std::vector<Point<Dim>>> sets;
  for (const auto& map : maps) sets.push_back(map.feature_estimates);
  PoseIndex pose = kWorld;
  for (const auto& observation : observations) {
    if (std::exchange(pose, observation.base) != observation.base) sets.emplace_back();
    sets.back().push_back(observation.measured);
  }
  return sets;
}

}  // namespace

template <int Dim>
PointMatrix<Dim> mean_noise(std::span<const FeatureFactor<Dim>> observations, const std::vector<LocalMap<Dim>>& maps) {
  PointMatrix<Dim> information = PointMatrix<Dim>::Zero();
  std::size_t points = observations.size();
  for (const auto& observation : observations) information += observation.information;
  for (const auto& map : maps) {
    points += map.features.size();
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      const Eigen::Index row = map.row(map.poses.size() + f);
      information += map.information.template block<Dim, Dim>(row, row);
    }
  }
  if (information_rank<Dim>(information) < Dim) return PointMatrix<Dim>::Zero();
  return static_cast<double>(points) * information.inverse();
}

template <int Dim>
NeighbourDensity<Dim> density_of(std::span<const FeatureFactor<Dim>> observations, const std::vector<LocalMap<Dim>>& maps) {
  return NeighbourDensity<Dim>(seen_at_once<Dim>(observations, maps), mean_noise<Dim>(observations, maps));
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                \
  template PointMatrix<Dim> mean_noise(std::span<const FeatureFactor<Dim>>, const std::vector<LocalMap<Dim>>&); \
  template NeighbourDensity<Dim> density_of(std::span<const FeatureFactor<Dim>>, const std::vector<LocalMap<Dim>>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
