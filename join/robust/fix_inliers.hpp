// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The fixes of a satellite receiver that are wrong: what the World says of a pose (GNSS), against all that the log says.

#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/model/log.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// A fix that is farther from the map by the other fixes than its covariance allows.
struct RejectedFix {
  std::size_t prior = 0;     ///< Among the pose priors of the log.
  double chi2 = 0.0;         ///< The squared Mahalanobis distance from the map.
  double probability = 1.0;  ///< Of so large a distance of any fix, were all right.
};

/// Finds the wrong ones among the pose priors of a log, all of which are fixes. The map without them is placed by the rigid
/// motion that brings the most of its antenna positions near their fixes (least median of squares over random pairs, in space
/// triples); from there all is solved with losses that are cut off at what the confidence allows, by graduated non-convexity,
/// and then again with those fixes alone that cost less; what is then too far off is wrong. None are found where too few fixes
/// stand apart to tell. Bad input: a log that nothing but its fixes ties together, and fixes of which too few agree to hold the
/// map; kInterrupted on `stop`.
template <int Dim>
Expected<std::vector<RejectedFix>> find_wrong_fixes(const Log<Dim>& log, const RobustOptions& options,
                                                    const std::stop_token& stop = {});

/// The log without these of its pose priors, ascending.
template <int Dim>
Log<Dim> without_fixes(const Log<Dim>& log, const std::vector<RejectedFix>& rejected);

}  // namespace mapjoin
