// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Checks of whether the headings of a planar log are in degrees, where radians are meant.

#include <mapjoin/check/finding.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// In the plane; in space nothing, for files give rotations there that degrees would not pass for.
/// - `degrees` (warning): relative headings beyond a full turn, one in a hundred or more; or short loops, of odometry and what
/// was seen before and after
///   it, that close far better with headings taken as degrees; or headings of the file's values that turn 57.3 times more, or
///   less, than its edges; or odometry whose heading is uncertain by more than a quarter turn.
/// - `unwrapped` (note): relative headings between a half and a full turn, which are taken as they are.
template <int Dim>
Findings check_units(const Log<Dim>& log);

}  // namespace mapjoin
