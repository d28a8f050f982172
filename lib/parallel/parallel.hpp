// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Independent pieces of work on all threads (as many as the caller's tbb::global_control allows).
//
// No piece may use what another one writes; their results are combined in a fixed order, so that any number of threads gives
// the same result.

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace mapjoin {

/// The number of poses or observations that make a piece of work.
inline constexpr std::size_t kObservationsPerPiece = 500;

/// Calls f(k) for every k in [0, count), in parallel; returns when all have returned. Rethrows exceptions.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& f);

/// Calls f and g in parallel.
void parallel_invoke(const std::function<void()>& f, const std::function<void()>& g);

/// Calls f(k) for every k in [0, count), in parallel, and g(k), one at a time and in order, once f(k) has returned; ends when a
/// g returns false. g(k) may use the results of f(k). f is less than `at_once`, at least 1, ahead of g. Rethrows exceptions.
void parallel_in_order(std::size_t count, std::size_t at_once, const std::function<void(std::size_t)>& f,
                       const std::function<bool(std::size_t)>& g);

/// Calls f(begin, end) for the pieces of [0, count) that have `grain` elements, the last one maybe fewer.
template <typename F>
void parallel_chunks(std::size_t count, std::size_t grain, F&& f) {
  parallel_for((count + grain - 1) / grain, [&](std::size_t k) { f(k * grain, std::min(count, (k + 1) * grain)); });
}

/// The sum of f(k) over [0, count), in parallel pieces of `grain` terms.
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
