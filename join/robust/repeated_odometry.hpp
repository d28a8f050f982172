// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Odometry that is told twice: which of the later edges between two successive poses contradict the first one?

#include <cstddef>
#include <mapjoin/model/log.hpp>
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

}  // namespace mapjoin
