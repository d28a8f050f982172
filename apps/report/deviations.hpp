// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How certain a map is in four numbers: its positions, and what they hang by.

#include <Eigen/Core>
#include <cmath>
#include <mapjoin/join/map_covariances.hpp>

namespace mapjoin::apps {

/// The standard deviation of a position: the square root of the trace of its covariance (m).
template <int Dim, typename Covariance>
double position_deviation(const Covariance& covariance) {
  return std::sqrt(covariance.template topLeftCorner<Dim, Dim>().trace());
}
/// That of a rotation (rad).
template <int Dim>
double rotation_deviation(const PoseMatrix<Dim>& covariance) {
  return std::sqrt(covariance.template bottomRightCorner<kRotationDof<Dim>, kRotationDof<Dim>>().trace());
}

/// Medians of position_deviation() (m).
struct Deviations {
  struct Median {
    double in_map = 0.0;
    double relative = 0.0;  ///< To the pose that it hangs from.
  };
  Median poses;  ///< But for those that are held.
  Median features;
};

template <int Dim>
Deviations deviations_of(const MarginalCovariances<Dim>& marginals);

}  // namespace mapjoin::apps
