// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Outliers among the fixes of a satellite receiver (GNSS), priors on poses: found by all that the log says.

#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/model/log.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// A fix that was left out, as it is farther from what all else predicts than the covariance of both allows.
struct RejectedFix {
  std::size_t prior = 0;     ///< Its place among the pose priors of the log.
  double chi2 = 0.0;         ///< The squared Mahalanobis distance from the prediction by all that counts.
  double probability = 1.0;  ///< Probability that any fix is so far off if all are right.
};

/// Finds the outliers among the pose priors of a log, all of which are fixes, separately in each part that nothing else ties to
/// the rest. The map without them is placed by the rigid motion that brings most of its antenna positions near their fixes
/// (least median of squares over random pairs, triples in space). If all fixes together then pass their tests, each against all
/// else, none is an outlier. Otherwise the part is solved with losses truncated at the threshold of the confidence, by
/// graduated non-convexity, and then again with only the fixes that cost less: those that fail their tests are dropped, the
/// farthest first, and those that pass theirs are readmitted, once. None are found in a part if too few of its fixes stand
/// apart to tell. kBadInput if check_invariants() finds a fault, or if too few fixes agree to determine a map; kInterrupted on
/// stop.
template <int Dim>
Expected<std::vector<RejectedFix>> find_wrong_fixes(const Log<Dim>& log, const RobustOptions& options,
                                                    const std::stop_token& stop = {});

/// The log without the rejected ones (ascending) of its pose priors.
template <int Dim>
Log<Dim> without_fixes(const Log<Dim>& log, const std::vector<RejectedFix>& rejected);

}  // namespace mapjoin
