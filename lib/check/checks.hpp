// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Checks of a log or a set of maps that need no estimate: what ties it together, its units, and what it says more than once.

#include <mapjoin/check/finding.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/map_set.hpp>

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

/// In the plane; in space nothing, for files give rotations there that degrees would not pass for.
/// - `degrees` (warning): relative headings beyond a full turn, one in a hundred or more; or short loops, of odometry and what
/// was seen before and after
///   it, that close far better with headings taken as degrees; or headings of the file's values that turn 57.3 times more, or
///   less, than its edges; or odometry whose heading is uncertain by more than a quarter turn.
/// - `unwrapped` (note): relative headings between a half and a full turn, which are taken as they are.
template <int Dim>
Findings check_units(const Log<Dim>& log);

/// Of edges between the same two poses, whatever their direction, and of observations of one feature from one pose:
/// - `copies` (warning): they are alike to the last digit, so that what was measured once counts twice;
/// - `contradiction` (warning): they differ by more than their covariances allow but once in 10⁹ times;
/// - `repeated` (note): neither; all of them count.
/// Each is compared with the one before it in the log. O(n log n).
template <int Dim>
Findings check_repeats(const Log<Dim>& log);

}  // namespace mapjoin
