// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Odometry that closures contradict: sessions are cut there, and the step is judged as a closure.

#include <functional>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/screening.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The log with a new session from each of some poses (ascending) on: the odometry steps to them become closures. Indices of
/// poses stay.
template <int Dim>
Log<Dim> cut_before(const Log<Dim>& log, const std::vector<PoseIndex>& poses);

/// The poses after odometry steps that closures contradict, ascending. Two closures that form a loop with odometry are evidence
/// for or against the steps in between, weighted by the probabilities that both are right; of neighbouring steps only the worst
/// is listed.
template <int Dim>
std::vector<PoseIndex> doubtful_steps(const ClosureSupport<Dim>& support);

/// Finds the inliers of a log whose odometry is believed, given its screening.
template <int Dim>
using SearchOf = std::function<Expected<Inliers<Log<Dim>>>(const Log<Dim>&, const Screening<Dim>&)>;

/// The inliers of a log whose odometry may be wrong. The log is cut at doubtful steps, and then searched; steps that set
/// closures against each other are cut, too, if fewer are rejected then, and so are, up to three times, those that the verdict
/// on the map finds out of line. Errors are those of the search and of run().
template <int Dim>
Expected<Inliers<Log<Dim>>> without_doubtful_odometry(const Log<Dim>& log, const RobustOptions& options,
                                                      const SearchOf<Dim>& search, const std::stop_token& stop);

}  // namespace mapjoin
