// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Selections of the closures and observations of a log that leave it connected.

#include <cstddef>
#include <mapjoin/model/log.hpp>
#include <vector>

namespace mapjoin {

/// The log with some of its closures (ascending) and some of its observations; with all of its observations if the flags are
/// empty.
template <int Dim>
Log<Dim> selected(const Log<Dim>& log, const std::vector<std::size_t>& closures, const std::vector<bool>& observations);

/// The chosen closures, ascending, and, if these leave the log in parts, those of the others with the largest odds that connect
/// them. Observations and priors connect, too; odometry that leaves a direction free does only where no closure can. One robot
/// that sees another does not measure its rotation: if nothing else connects two sessions, all such closures between them are
/// taken.
template <int Dim>
std::vector<std::size_t> tied_together(const Log<Dim>& log, const std::vector<double>& odds, std::vector<bool> is_chosen);

/// Sets the flag of one observation of each feature that has none: the one with the smallest number in `against`.
template <int Dim>
void keep_one_of_each_feature(const Log<Dim>& log, const std::vector<double>& against, std::vector<bool>& observations);

}  // namespace mapjoin
