// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Robust joining: what is wrong in a log, or in local maps, is found and left out, without an initial value.

#include <mapjoin/join/fit/goodness_of_fit.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

/// What is asked of a search for what is wrong.
struct RobustOptions {
  double confidence = 0.99;  ///< The probability that nothing right is rejected in the whole log; in (0, 1).
  Engine engine = Engine::kFronts;
  bool odometry = false;  ///< May be rejected, too, where closures contradict it.

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

enum class WhyRejected : std::uint8_t {
  kContradicted,  ///< It is farther from what all others say than its covariance allows.
  kCrowded,       ///< Its covariance would allow it, but others fit more closely, and what a wrong one measured would fit, too.
};
constexpr auto enum_names(WhyRejected) {
  return std::to_array<EnumName<WhyRejected>>(
      {{WhyRejected::kContradicted, "contradicted"}, {WhyRejected::kCrowded, "crowded"}});
}

/// A closure or an observation of a log, or a feature of a local map, that was left out. Its chi2 is the squared Mahalanobis
/// distance from its prediction by what was kept, not scaled; the probability is that of any closure or observation of the log.
struct Rejected {
  Misfit misfit;
  WhyRejected why = WhyRejected::kContradicted;
  std::size_t observation = 0;  ///< The place of an observation among those of the log.
};

/// A log, or a set of local maps.
template <typename Input>
struct Inliers {
  Input input;                     ///< Without what was rejected.
  std::vector<Rejected> rejected;  ///< Repeated odometry, closures, observations, features of maps.
};

/// Finds the closures and observations that do not agree with the others: closures are judged by the loops that they make with
/// each other and with odometry (ClosureSupport), the best supported ones are joined with truncated losses (TruncatedJoin), and
/// the map that comes of it judges all others, in rounds, the last of which try every rejected one again. Of fewer than a
/// hundred closures this is done from several first maps, and the search that rejects the fewest counts. Odometry and priors
/// are believed, but of two odometry edges between the same poses that contradict each other the later one is rejected. With
/// `odometry` drives are cut where closures, or the verdict on the map, speak against it, and the edge is judged as a closure.
/// Bad input: a log that falls apart; kInterrupted on `stop`. The same for any number of threads.
template <int Dim>
Expected<Inliers<Log<Dim>>> find_inliers(const Log<Dim>& log, const RobustOptions& options, const std::stop_token& stop = {});

/// Finds the features of local maps that are under a wrong name, as the observations of a log that has, of each pose and
/// feature of a map, what the map says of it alone. The maps are kept, without these features: what they say of the others
/// stays as it was. Observations that stand on their own in the set are judged, too; all that relates poses is believed.
template <int Dim>
Expected<Inliers<SubmapSet<Dim>>> find_inliers(const SubmapSet<Dim>& set, const RobustOptions& options,
                                               const std::stop_token& stop = {});

}  // namespace mapjoin
