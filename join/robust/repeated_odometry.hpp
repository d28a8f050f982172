// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Odometry that is told twice: which of the later edges between two successive poses contradict the first one?

#include <cstddef>
#include <mapjoin/join/robust/inliers.hpp>
#include <vector>

namespace mapjoin {

/// An edge of a log's odometry that repeats an earlier one, and its squared Mahalanobis distance from it, by both covariances.
struct RepeatedOdometry {
  std::size_t edge = 0;
  double chi2 = 0.0;
};

/// In the order of the odometry.
template <int Dim>
std::vector<RepeatedOdometry> repeated_odometry(const Log<Dim>& log);

/// The log without repeated odometry that contradicts the first edge. With the probability `confidence` nothing is rejected of
/// a log that is right, were all its closures and observations tested, too.
template <int Dim>
Inliers<Log<Dim>> without_contradicted_odometry(const Log<Dim>& log, double confidence);

}  // namespace mapjoin
