// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The search for the closures and observations of a log that agree, from a first map on.

#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/screening.hpp>
#include <stop_token>

namespace mapjoin {

/// The one of two results that rejects fewer, `a` on a tie; the other one if one has failed.
template <int Dim>
Expected<Inliers<Log<Dim>>> fewer_rejected(Expected<Inliers<Log<Dim>>> a, Expected<Inliers<Log<Dim>>> b);

/// Finds inliers by maps of ever more closures, from log-odds of at least `first_odds` down to kLeastOdds, or by one map if
/// `first_odds` is no larger; each map tests all closures. At the end all that was rejected is tried again. If a few kept
/// closures are outnumbered by rejected ones, the search also goes on without them, and the result that rejects fewer is
/// returned. `screening` is of the same log. Errors as of find_inliers(). Once a stop is requested the result is of no use.
template <int Dim>
Expected<Inliers<Log<Dim>>> search_inliers(const Log<Dim>& log, const Screening<Dim>& screening, double first_odds,
                                           Engine engine, const std::stop_token& stop);

}  // namespace mapjoin
