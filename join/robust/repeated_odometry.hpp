// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Repeated odometry: later edges between two successive poses, and those that contradict the first one.

#include <cstddef>
#include <mapjoin/join/robust/inliers.hpp>
#include <vector>

namespace mapjoin {

/// An odometry edge that repeats an earlier one, and its squared Mahalanobis distance from that by both covariances.
struct RepeatedOdometry {
  std::size_t edge = 0;
  double chi2 = 0.0;
};

/// The repeated edges of a log, in the order of its odometry.
template <int Dim>
std::vector<RepeatedOdometry> repeated_odometry(const Log<Dim>& log);

/// The log without repeated odometry that contradicts the first edge. In a log without outliers nothing is rejected with
/// probability `confidence`, even if all its closures and observations are tested, too.
template <int Dim>
Inliers<Log<Dim>> without_contradicted_odometry(const Log<Dim>& log, double confidence);

}  // namespace mapjoin
