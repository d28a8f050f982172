// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Options that do not validate are a promise broken by the caller.

#include <stdexcept>

namespace mapjoin {

/// Throws std::invalid_argument with the first violation, where there is one.
template <typename Options>
void demand_valid(const Options& options) {
  const auto violations = options.validate();
  if (!violations.empty()) throw std::invalid_argument(violations.front());
}

}  // namespace mapjoin
