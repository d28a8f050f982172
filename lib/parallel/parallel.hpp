// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Independent pieces of work on all threads (as many as the caller's tbb::global_control allows).
//
// No piece may use what another one writes; what they compute is put together in a fixed order, so that any number
// of threads gives the same result.

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace mapjoin {

/// Poses or observations that are worth a piece of work.
inline constexpr std::size_t kObservationsPerPiece = 500;

/// Calls f(k) for every k in [0, count); returns when all have returned. What one of them throws is thrown here.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& f);

/// Calls f and g side by side.
void parallel_invoke(const std::function<void()>& f, const std::function<void()>& g);

/// Calls f(k) for every k in [0, count), side by side, and meanwhile g(k), one at a time and in order, for those of which f has
/// returned; until a g returns false. g(k) may use what f(k) wrote. f is less than `at_once`, at least 1, ahead of g. What one
/// of them throws is thrown here.
void parallel_in_order(std::size_t count, std::size_t at_once, const std::function<void(std::size_t)>& f,
                       const std::function<bool(std::size_t)>& g);

/// Calls f(begin, end) for the pieces of [0, count) that have `grain` elements, the last one maybe fewer.
template <typename F>
void parallel_chunks(std::size_t count, std::size_t grain, F&& f) {
  parallel_for((count + grain - 1) / grain, [&](std::size_t k) { f(k * grain, std::min(count, (k + 1) * grain)); });
}

/// The sum of f(k) over [0, count), `grain` terms at a time side by side.
template <typename F>
double parallel_sum(std::size_t count, std::size_t grain, F&& f) {
  std::vector<double> sums((count + grain - 1) / grain, 0.0);
  parallel_chunks(count, grain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t k = begin; k < end; ++k) sum += f(k);
    sums[begin / grain] = sum;
  });
  double sum = 0.0;
  for (const double part : sums) sum += part;
  return sum;
}

}  // namespace mapjoin
