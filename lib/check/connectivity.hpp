// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Connectivity of a log or a set of maps, and its parts: connected components over poses, features and the World.

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <vector>

namespace mapjoin {

/// kBadInput if there are no poses, if check_invariants() finds a fault in a log, if it has poses and no edges, if a feature is
/// never observed, or if there is more than one component, named by a pose or feature of each of the first few. The World ties
/// together all that it fixes or has priors for.
template <typename LogOrSet>
Expected<void> check_connected(const LogOrSet& tied);

/// The connected components of a log, each as a log, by descending number of poses; equally large ones by first vertex
/// (TieVertices). Features that nothing observes belong to none. Entries left out on reading are counted in the first one.
template <int Dim>
std::vector<Log<Dim>> split_into_parts(const Log<Dim>& log);

}  // namespace mapjoin
