// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whether a map is as certain as it is right: its errors against the truth, in units of its covariance.

#include <Eigen/Core>
#include <mapjoin/join/covariances/map_covariances.hpp>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// What is known of the true poses and features of a submap graph, by their indices, in any one frame.
template <int Dim>
struct Truth {
  Table<PoseIndex, std::optional<Pose<Dim>>> poses;
  Table<FeatureIndex, std::optional<Point<Dim>>> features;
};

/// The normalised estimation error squared, eᵀ P⁻¹ e with the joint covariance P of all of e: of a consistent map, a value of
/// chi-square with that many dimensions.
struct Nees {
  double value = 0.0;
  Eigen::Index dimensions = 0;

  double least() const;        ///< What 1 % of consistent maps are below,
  double most() const;         ///< and what 99 % are below.
  double probability() const;  ///< Of a larger value.
};

/// Each over what is known of the truth, with all else free.
struct Consistency {
  Nees poses;
  Nees features;
  Nees joint;
};

/// Errors are steps from the estimate to the truth. Where one pose holds the map, the truth is moved so that it agrees there,
/// else its frame is the map's; of a truth without that pose, or with nothing but what holds the map, nothing can be said: all
/// dimensions are 0. kUsage where the truth has nothing of the map; kInterrupted on `stop`; else as MapCovariances.
template <int Dim>
Expected<Consistency> consistency(const MapCovariances<Dim>& covariances, const Truth<Dim>& truth,
                                  const std::stop_token& stop = {});

}  // namespace mapjoin
