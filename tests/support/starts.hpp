// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Initial values for a whole log, made without the library's own solvers, from which a reference optimiser can start.

#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <mapjoin/model/values.hpp>
#include <optional>
#include <vector>

namespace mapjoin::testing {

/// Every feature where its first observation (or prior) puts it, seen from the given poses.
template <int Dim>
Values<Dim> with_first_observations(const Log<Dim>& log, Table<PoseIndex, Pose<Dim>> poses);

template <int Dim>
Values<Dim> with_first_observations(const SubmapSet<Dim>& set, Table<PoseIndex, Pose<Dim>> poses);

/// Each session dead-reckoned from its first pose; features by their first observations.
template <int Dim>
Values<Dim> odometry_start(const Log<Dim>& log);

/// Poses breadth-first over all pose-pose edges, odometry and closures alike; features by their first observations.
template <int Dim>
Values<Dim> spanning_tree_start(const Log<Dim>& log);

/// Maps composed end to end, breadth-first over their poses and the pose-pose edges beside them; features by the first map that
/// holds them.
template <int Dim>
Values<Dim> composed_start(const SubmapSet<Dim>& set);

/// The values of the file; features by their first observations where it has none of theirs. Nothing without its poses.
template <int Dim>
std::optional<Values<Dim>> file_start(const Log<Dim>& log);

}  // namespace mapjoin::testing
