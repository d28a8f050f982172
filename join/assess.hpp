// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What is said of a map once it is found: does it fit, and how certain is it?

#include <mapjoin/join/restored.hpp>
#include <mapjoin/join/run.hpp>
#include <optional>
#include <span>
#include <stop_token>

namespace mapjoin {

/// A map, and what its verdict and covariances are made from, where they are asked for.
template <int Dim>
struct Found {
  RunResult<Dim> result;
  std::optional<Restored<Dim>> restored;
};

bool wants_assessment(const RunOptions& options);

/// The result with its verdict, and with the covariances that were asked for, by one factorisation at the estimate. A map that
/// has none is a result all the same. `odometry` is that of the log, if there is one.
template <int Dim>
Expected<RunResult<Dim>> assessed(Found<Dim> found, std::span<const PoseFactor<Dim>> odometry, const RunOptions& options,
                                  const std::stop_token& stop);

}  // namespace mapjoin
