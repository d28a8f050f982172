// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The certainty of a map: four medians, and the files beside the map.

#include <cmath>
#include <filesystem>
#include <mapjoin/join/covariances/map_covariances.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <optional>

namespace mapjoin::apps {

/// Medians of the standard deviations of positions (m).
struct Deviations {
  struct Median {
    double in_map = 0.0;
    double relative = 0.0;  ///< Relative to the parents.
  };
  std::optional<Median> poses;  ///< Without anchored poses; nullopt if there are no others.
  std::optional<Median> features;
};

/// The standard deviation of a position (m), the square root of the trace of its covariance.
template <int Dim, typename Covariance>
double position_deviation(const Covariance& covariance) {
  return std::sqrt(covariance.template topLeftCorner<Dim, Dim>().trace());
}

/// The size of a map along its longest axis (m).
template <int Dim>
double extent_of(const GlobalMap<Dim>& map);

template <int Dim>
Deviations deviations_of(const MarginalCovariances<Dim>& marginals);

/// Writes the marginal covariances that `map` holds, as JSON that names their estimate; kCannotWrite.
template <int Dim>
Expected<void> write_covariances(const GlobalMap<Dim>& map, Estimate estimate, const std::filesystem::path& path);

/// Writes a CSV line per pose, after that of its parent, then one per feature; kCannotWrite.
template <int Dim>
Expected<void> write_relations(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals,
                               const std::filesystem::path& path);

}  // namespace mapjoin::apps
