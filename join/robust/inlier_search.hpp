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

/// The others are for a closure or observation whose odds (a logarithm) are above this, and against it where they are below
/// its negative.
inline constexpr double kLeastOdds = 3.0;

/// What is known of a log before anything is solved: what odometry and closures say of each other, and observations of each
/// other.
template <int Dim>
struct Screening {
  OdometryChain<Dim> chain;
  ClosureSupport<Dim> support;
  double doubtful_count;  ///< Closures and observations; at least 1.
  Gates gates;
  std::vector<PriorOdds> priors;         ///< Of closures.
  std::vector<double> odds;              ///< Of closures, logarithms.
  std::vector<bool> observations_count;  ///< Those that others are for, and one at least of each feature.
  std::size_t outvoted = 0;              ///< Closures and observations that others are against.

  /// Of a log whose odometry is believed; some is missing once a stop is requested. `confidence` as of RobustOptions.
  Screening(const Log<Dim>& log, double confidence, const std::stop_token& stop);
  Screening(const Screening&) = delete;  // `support` refers to `chain`
  Screening& operator=(const Screening&) = delete;

 private:
  void screen_closures();
  void screen_observations(const Log<Dim>& log);
};

/// That of two results which rejects fewer, `a` where both reject as many; the other one where one has failed.
template <int Dim>
Expected<Inliers<Log<Dim>>> fewer_rejected(Expected<Inliers<Log<Dim>>> a, Expected<Inliers<Log<Dim>>> b);

/// Maps of ever more closures, from those of at least `first_odds` (a logarithm) down to kLeastOdds, or one map where that is
/// no more; each judges all of them. At the end all that was rejected is tried again. Where few that are kept are outnumbered
/// by rejected ones, the search also goes on without them, and the result that rejects fewer is returned. `screening` is of the
/// same log. Errors as of find_inliers(). Once a stop is requested the result is of no use.
template <int Dim>
Expected<Inliers<Log<Dim>>> search_inliers(const Log<Dim>& log, const Screening<Dim>& screening, double first_odds,
                                           Engine engine, const std::stop_token& stop);

}  // namespace mapjoin
