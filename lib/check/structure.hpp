// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Checks of what ties a log or a set of maps together, whatever its numbers are.

#include <mapjoin/check/finding.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// - `unobserved` (error): features that are declared, but never observed.
/// - `parts` (error): several components that nothing ties together.
/// - `loose_body` (error), `weak_body` (warning): poses that are tied to the others by features only, by fewer than it takes to
///   hold them, Dim, or by just as many.
/// - `weak_link`, `weak_feature` (warnings): see graph/weak_links.hpp.
/// - `seen_once` (note; of a log a warning where it is most of them): features that add nothing to the map.
/// - `breaks` (note): steps without odometry within one session of the user's.
/// - `unassociated` (note): observations left out by the reader.
template <int Dim>
Findings check_structure(const Log<Dim>& log);
template <int Dim>
Findings check_structure(const MapSet<Dim>& set);

}  // namespace mapjoin
