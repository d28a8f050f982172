// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whether a log or a set of maps hangs together: connected components over poses, features and the World.

#include <mapjoin/model/error.hpp>

namespace mapjoin {

/// Bad input where there is more than one component, naming a pose or feature of each of the first few; a feature that nothing
/// observes is named as such. The World ties together all that it fixes or has priors for.
template <typename LogOrSet>
Expected<void> check_connected(const LogOrSet& tied);

}  // namespace mapjoin
