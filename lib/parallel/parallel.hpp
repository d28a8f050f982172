// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Independent pieces of work on all threads (as many as the caller's tbb::global_control allows).
//
// No piece may use what another one writes; what they compute is put together afterwards, in a fixed order, so that any number
// of threads gives the same result.

#include <cstddef>
#include <functional>

namespace mapjoin {

/// Calls f(k) for every k in [0, count); returns when all have returned. What one of them throws is thrown here.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& f);

/// Calls f and g side by side.
void parallel_invoke(const std::function<void()>& f, const std::function<void()>& g);

}  // namespace mapjoin
