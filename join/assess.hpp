// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Assessment of a map once it is found: does it fit, and how certain is it?

#include <mapjoin/join/restored.hpp>
#include <mapjoin/join/run.hpp>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

namespace mapjoin {

/// A map, and the restored join that its verdict and covariances are computed from, present if they are asked for.
template <int Dim>
struct Found {
  RunResult<Dim> result;
  std::optional<Restored<Dim>> restored;
};

/// Bad input, with the source of the data named, if the map or its chi2 is not finite.
template <int Dim>
Expected<void> check_finite(const RunResult<Dim>& result, const std::string& source);

bool wants_assessment(const RunOptions& options);

/// The result with its verdict and the covariances that were asked for, by one factorisation at the estimate. If the
/// covariances are not finite, the result says so and is returned all the same; kTooLarge as MapCovariances; kInterrupted on
/// `stop`. `odometry` is that of the log; empty if there is no log.
template <int Dim>
Expected<RunResult<Dim>> assessed(Found<Dim> found, std::span<const PoseFactor<Dim>> odometry, const RunOptions& options,
                                  const std::stop_token& stop);

}  // namespace mapjoin
