// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whether a log or a set of maps hangs together, and its parts: connected components over poses, features and the World.

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <vector>

namespace mapjoin {

/// Bad input where there is more than one component, naming a pose or feature of each of the first few; a feature that nothing
/// observes is named as such. The World ties together all that it fixes or has priors for.
template <typename LogOrSet>
Expected<void> check_connected(const LogOrSet& tied);

/// The connected components of a log, each as a log; that with most poses first, of as many the one that begins first. Features
/// that nothing observes are of none. What reading left out is counted in the first one.
template <int Dim>
std::vector<Log<Dim>> split_into_parts(const Log<Dim>& log);

}  // namespace mapjoin
