// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Robust joining: finds the outliers of a log, or of local maps, and leaves them out, without an initial value.

#include <mapjoin/join/fit/goodness_of_fit.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

/// Options of the search for outliers.
struct RobustOptions {
  double confidence = 0.99;  ///< The probability that nothing right is rejected in the whole log; in (0, 1).
  Engine engine = Engine::kFronts;
  bool odometry = false;  ///< True if odometry that closures contradict may be rejected, too.

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

enum class WhyRejected : std::uint8_t {
  kContradicted,  ///< Farther from the prediction by all others than its covariance allows.
  kCrowded,       ///< Its covariance would allow it, but others fit more closely, and a wrong measurement would fit, too.
};
constexpr auto enum_names(WhyRejected) {
  return std::to_array<EnumName<WhyRejected>>(
      {{WhyRejected::kContradicted, "contradicted"}, {WhyRejected::kCrowded, "crowded"}});
}

/// A closure, an observation or a repeated odometry edge of a log, or a feature of a local map, that was left out. Its chi2 is
/// the squared Mahalanobis distance from its prediction by what was kept, not scaled; its probability is that of so large a
/// distance of any closure or observation of the log.
struct Rejected {
  Misfit misfit;
  WhyRejected why = WhyRejected::kContradicted;
  std::size_t observation = 0;  ///< The place of an observation among those of the log.
};

/// A log or a set of local maps, and what was rejected of it.
template <typename Input>
struct Inliers {
  Input input;                     ///< The input without what was rejected.
  std::vector<Rejected> rejected;  ///< Repeated odometry, closures, observations, features of maps.
};

/// Finds the closures and observations that do not agree with the others. Closures are judged by the loops that they form with
/// each other and with odometry (ClosureSupport); the best supported ones are joined with truncated losses (TruncatedJoin), and
/// the map tests all others, in rounds, the last of which try every rejected one again. With fewer than a hundred closures the
/// search starts from several first maps, and the one that rejects the fewest counts. Odometry and priors are believed, except
/// that of two odometry edges between the same poses that contradict each other the later one is rejected. With `odometry`,
/// sessions are cut where closures, or the verdict on the map, contradict odometry, and the edge is judged as a closure.
/// kBadInput if the log is not connected, or if what agrees leaves something undetermined; kInterrupted on stop. The result is
/// the same for any number of threads.
template <int Dim>
Expected<Inliers<Log<Dim>>> find_inliers(const Log<Dim>& log, const RobustOptions& options, const std::stop_token& stop = {});

/// Finds the features of local maps that have a wrong name, as the observations of a log: it has, of each map, each feature by
/// its marginal and each pose relative to the one before. The maps are kept without the rejected features; what they say of the
/// others stays as it was. Observations that stand on their own in the set are judged, too; everything that relates poses is
/// believed. Where residuals of what is kept are larger than its covariances say, all is judged again with covariances as
/// much larger.
template <int Dim>
Expected<Inliers<SubmapSet<Dim>>> find_inliers(const SubmapSet<Dim>& set, const RobustOptions& options,
                                               const std::stop_token& stop = {});

}  // namespace mapjoin
