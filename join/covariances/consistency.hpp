// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The consistency of a map: its errors against the truth, in units of its covariance.

#include <Eigen/Core>
#include <mapjoin/join/covariances/map_covariances.hpp>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The known true poses and features of a submap graph, by their indices, in any one frame; nullopt if unknown.
template <int Dim>
struct Truth {
  Table<PoseIndex, std::optional<Pose<Dim>>> poses;
  Table<FeatureIndex, std::optional<Point<Dim>>> features;
};

/// The normalised estimation error squared, eᵀ P⁻¹ e with the joint covariance P of e: for a consistent map a value of
/// chi-square with `dimensions` degrees of freedom.
struct Nees {
  double value = 0.0;
  Eigen::Index dimensions = 0;

  double least() const;        ///< The 1 % quantile of consistent maps.
  double most() const;         ///< The 99 % quantile of consistent maps.
  double probability() const;  ///< The probability of a larger value.
};

/// The NEES of the known poses, of the known features, and of both together, each with all other variables marginalised.
struct Consistency {
  Nees poses;
  Nees features;
  Nees joint;
};

/// The consistency of a map with the truth; errors are steps from the estimate to the truth. If one pose is anchored, the truth
/// is moved to agree with the map there; otherwise it must be in the frame of the map. All dimensions are 0 if the truth lacks
/// that pose or has nothing but anchored poses. kUsage if the truth has nothing of the map; kInterrupted on `stop`; otherwise
/// errors as MapCovariances.
template <int Dim>
Expected<Consistency> consistency(const MapCovariances<Dim>& covariances, const Truth<Dim>& truth,
                                  const std::stop_token& stop = {});

}  // namespace mapjoin
