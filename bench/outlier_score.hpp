// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How well wrong measurements that were planted into a log were told from its own, and what the map is worth that was made of
// the others.

#include <cstddef>
#include <mapjoin/join/run.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <memory>
#include <vector>

namespace mapjoin::bench {

/// A feature is off that is this far from where the clean map has it (squared Mahalanobis distance).
inline constexpr double kOffFrom = 3.0 * 3.0;

/// The map of a log without planted measurements, by which these are judged.
template <int Dim>
struct CleanMap {
  Log<Dim> log;
  Values<Dim> values;
  double chi2 = 0.0;
  double cpu_seconds = 0.0;  ///< Of run() without a verdict.
  MarginalCovariances<Dim> marginals;
  std::shared_ptr<const MapCovariances<Dim>> covariances;
};

/// Errors are those of run().
template <int Dim>
Expected<CleanMap<Dim>> make_clean_map(const Log<Dim>& log);

/// What a planted or own measurement counts as.
enum class Truth : std::uint8_t {
  kRight,
  kWrong,
  kUndecided,  ///< Planted, but not to be told from right ones: near its prediction, or of features that are hardly seen.
};

/// For each closure of a log and then for each observation.
template <int Dim>
struct Spoilt {
  Log<Dim> log;
  std::vector<Truth> truth;
};

/// Planted measurements are wrong where they are more than 10 standard deviations from what the clean map predicts
/// (Mahalanobis, by the covariances of both); of observations only those whose true and given names have two other sightings
/// each that are right.
template <int Dim>
Spoilt<Dim> with_wrong_closures(const CleanMap<Dim>& clean, ClosurePolicy policy, std::size_t count, std::uint64_t seed);
template <int Dim>
Spoilt<Dim> with_wrong_identities(const CleanMap<Dim>& clean, double share, std::uint64_t seed);

/// What a method makes of a spoilt log.
template <int Dim>
struct RobustMap {
  Log<Dim> kept;  ///< The log without what was rejected.
  Values<Dim> values;
  double cpu_seconds = 0.0;
};

struct OutlierScore {
  std::size_t right = 0;
  std::size_t right_rejected = 0;
  std::size_t wrong = 0;
  std::size_t wrong_rejected = 0;
  std::size_t undecided = 0;
  std::size_t undecided_rejected = 0;
  double rms = 0.0;              ///< Of the distances of poses from the clean map (m).
  double chi2_ratio = 0.0;       ///< chi2 of the log's own measurements over its least one.
  std::size_t features_off = 0;  ///< More than 3 standard deviations from the clean map.

  double precision() const;
  double recall() const;
};

template <int Dim>
OutlierScore score(const CleanMap<Dim>& clean, const Spoilt<Dim>& spoilt, const RobustMap<Dim>& robust);

}  // namespace mapjoin::bench
