// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One map of a log with outliers: its start, and which measurements count in it.

#include <mapjoin/join/robust/truncated_join.hpp>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <stop_token>
#include <string>

namespace mapjoin {

/// Gates on the squared Mahalanobis distance of a measurement from its prediction: within them it may count.
struct Gates {
  OfKinds widest;               ///< The gates of the confidence.
  OfKinds scale{1.0, 1.0};      ///< How closely inliers fit, as a share of the widest gates; see scale_of().
  std::optional<OfKinds> last;  ///< Used in place of the narrow ones when all are tried again.
  double confidence = 0.99;     ///< As in RobustOptions.

  OfKinds narrow() const { return {scale.closures * widest.closures, scale.observations * widest.observations}; }
  OfKinds now() const { return last.value_or(narrow()); }
};

/// A first estimate of a log, by a join. Errors are those of run(), except that edges may leave directions undetermined.
template <int Dim>
Expected<Values<Dim>> started_map(Log<Dim> log, Engine engine, const std::stop_token& stop);

/// Settles a join where all that counts passes its tests. Observations that do not count and pass theirs are readmitted at the
/// first estimate, and once more when nothing is left to drop; with `gates.last` closures are, too, this second time. Finds the
/// scale of `gates`. kBadInput, which names `source`, if what counts leaves something undetermined; kInterrupted on stop.
template <int Dim>
Expected<void> settle(TruncatedJoin<Dim>& join, Gates& gates, const std::string& source, const std::stop_token& stop);

}  // namespace mapjoin
