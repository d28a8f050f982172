// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Checks of what a log says more than once of the same two things.

#include <mapjoin/check/finding.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Of edges between the same two poses, whatever their direction, and of observations of one feature from one pose:
/// - `copies` (warning): they are alike to the last digit, so that what was measured once counts twice;
/// - `contradiction` (warning): they differ by more than their covariances allow but once in 10⁹ times;
/// - `repeated` (note): neither; all of them count.
/// Each is compared with the one before it in the log. O(n log n).
template <int Dim>
Findings check_repeats(const Log<Dim>& log);

}  // namespace mapjoin
