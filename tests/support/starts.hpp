// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Initial values for a whole log, made without the library's own solvers, from which a reference optimiser can start.

#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <mapjoin/model/values.hpp>
#include <optional>
#include <vector>

namespace mapjoin::testing {

/// The given poses, and every feature where its first observation (or prior) from them puts it.
template <int Dim>
Values<Dim> with_first_observations(const Log<Dim>& log, Table<PoseIndex, Pose<Dim>> poses);

template <int Dim>
Values<Dim> with_first_observations(const SubmapSet<Dim>& set, Table<PoseIndex, Pose<Dim>> poses);

/// Poses composed along odometry: from fixed poses, and in other sessions from the first pose, at the origin. Features by their
/// first observations.
template <int Dim>
Values<Dim> odometry_start(const Log<Dim>& log);

/// Poses composed breadth-first along all edges, odometry and closures alike; features by their first observations.
template <int Dim>
Values<Dim> spanning_tree_start(const Log<Dim>& log);

/// Poses composed breadth-first along local maps and the edges beside them; features by the first map that holds them.
template <int Dim>
Values<Dim> composed_start(const SubmapSet<Dim>& set);

/// The initial values of the file, features by their first observations if it has none of theirs; nullopt if it has none of
/// poses.
template <int Dim>
std::optional<Values<Dim>> file_start(const Log<Dim>& log);

}  // namespace mapjoin::testing
