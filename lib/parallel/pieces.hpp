// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Pieces of work that may fail, and large pieces that share out work of their own.

#include <algorithm>
#include <cstddef>
#include <functional>
#include <mapjoin/model/error.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <vector>

namespace mapjoin {

/// Calls f in isolation: a thread that waits for work shared out by f takes up no other piece from around f, so that no more of
/// these are under way than there are threads.
void isolated(const std::function<void()>& f);

/// The number of pieces of work that may be under way at a time: the threads of the caller.
std::size_t most_at_once();

/// Calls f(k) for every k in [0, count), in parallel. Returns the failure of the first k that fails, if any.
template <typename F>
Expected<void> parallel_try(std::size_t count, F&& f) {
  std::vector<Expected<void>> done(count);
  parallel_for(count, [&](std::size_t k) { done[k] = f(k); });
  const auto failed = std::find_if(done.begin(), done.end(), [](const auto& piece) { return !piece.has_value(); });
  return failed == done.end() ? Expected<void>() : *failed;
}

}  // namespace mapjoin
