// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The density of the features that poses and local maps see, and the noise of these sightings.

#include <mapjoin/join/association/matching/neighbour_density.hpp>
#include <mapjoin/model/factor.hpp>
#include <mapjoin/model/local_map.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// The covariance of a point (m²) with the mean information of all observations and features of local maps, of these given the
/// rest of their map; zero if that does not determine a point.
template <int Dim>
PointMatrix<Dim> mean_noise(std::span<const FeatureFactor<Dim>> observations, const std::vector<LocalMap<Dim>>& maps);

/// The density of features around those that the poses and local maps see. The observations of a pose follow one another; none
/// is a prior in the World.
template <int Dim>
NeighbourDensity<Dim> density_of(std::span<const FeatureFactor<Dim>> observations, const std::vector<LocalMap<Dim>>& maps);

}  // namespace mapjoin
