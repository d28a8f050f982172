// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Odometry that closures contradict: drives are cut there, so that the step is judged as closures are.

#include <functional>
#include <mapjoin/join/robust/inliers.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The log with a new session from each of some poses on, ascending: the steps of odometry to them become closures. Indices of
/// poses stay.
template <int Dim>
Log<Dim> cut_before(const Log<Dim>& log, const std::vector<PoseIndex>& poses);

/// The poses after steps of odometry that closures speak against, ascending. Two closures that make a loop with odometry speak
/// for or against the steps in between, by the odds that both are right; of neighbouring steps only the worst is named.
template <int Dim>
std::vector<PoseIndex> doubtful_steps(const Log<Dim>& log, const std::stop_token& stop = {});

/// Finds the inliers of a log whose odometry is believed.
template <int Dim>
using SearchOf = std::function<Expected<Inliers<Log<Dim>>>(const Log<Dim>&)>;

/// The inliers of a log whose odometry may be wrong: by a search in the log cut at doubtful steps, at others that set closures
/// against each other where fewer are rejected then and, as long as the verdict on its map finds other ones out of line, at
/// these, too. Errors are those of the search and of run().
template <int Dim>
Expected<Inliers<Log<Dim>>> without_doubtful_odometry(const Log<Dim>& log, const RobustOptions& options,
                                                      const SearchOf<Dim>& search, const std::stop_token& stop);

}  // namespace mapjoin
