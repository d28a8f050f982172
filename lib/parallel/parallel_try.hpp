// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Independent pieces of work of which each may fail.

#include <algorithm>
#include <mapjoin/model/error.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <vector>

namespace mapjoin {

/// Calls f(k) for every k in [0, count), side by side. The failure of the first k that fails, or nothing.
template <typename F>
Expected<void> parallel_try(std::size_t count, F&& f) {
  std::vector<Expected<void>> done(count);
  parallel_for(count, [&](std::size_t k) { done[k] = f(k); });
  const auto failed = std::find_if(done.begin(), done.end(), [](const auto& piece) { return !piece.has_value(); });
  return failed == done.end() ? Expected<void>() : *failed;
}

}  // namespace mapjoin
