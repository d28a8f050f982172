// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The search for the closures and observations of a log that agree, from a first map on.

#include <cstddef>
#include <mapjoin/join/robust/agreement.hpp>
#include <mapjoin/join/robust/closure_support.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/odometry_chain.hpp>
#include <mapjoin/join/robust/robust_map.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Evidence gathered before anything is solved: how well closures agree with odometry and with each other, and observations
/// among themselves.
template <int Dim>
struct Screening {
  OdometryChain<Dim> chain;
  SupportedClosures<Dim> closures;  ///< Within the scale of `gates`.
  double doubtful_count;            ///< Number of closures, observations and repetitions of odometry; at least 1.
  Gates gates;
  std::vector<bool> observations_count;  ///< True if others support it, and for at least one of each feature.
  std::size_t outvoted = 0;              ///< Number of closures and observations that others are against.

  /// Screens a log whose odometry is believed; incomplete once a stop is requested. `confidence` as in RobustOptions.
  Screening(const Log<Dim>& log, double confidence, const std::stop_token& stop);
  Screening(const Screening&) = delete;  // `closures` refer to `chain`
  Screening& operator=(const Screening&) = delete;

 private:
  void screen_closures();
  void screen_observations(const Log<Dim>& log);
};

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
