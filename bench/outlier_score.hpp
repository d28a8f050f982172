// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Scores of outlier rejection: how well wrong measurements planted into a log were told from its own, and the quality of the
// map made of the others.

#include <cstddef>
#include <mapjoin/join/run.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <memory>
#include <vector>

namespace mapjoin::bench {

/// CPU time of run() without a verdict on a log or a set of local maps: the median of three, since the first is slower. Errors
/// are those of run().
template <typename Data>
Expected<double> clean_cpu_seconds(const Data& data);

/// The map of a log without planted measurements, by which planted ones are judged.
template <int Dim>
struct CleanMap {
  Log<Dim> log;
  Values<Dim> values;
  double chi2 = 0.0;
  double cpu_seconds = 0.0;  ///< See clean_cpu_seconds().
  MarginalCovariances<Dim> marginals;
  std::shared_ptr<const MapCovariances<Dim>> covariances;
};

/// Makes the clean map of a log. Errors are those of run().
template <int Dim>
Expected<CleanMap<Dim>> make_clean_map(const Log<Dim>& log);

/// The class of a measurement, planted or the log's own.
enum class Truth : std::uint8_t {
  kRight,
  kWrong,
  kUndecided,  ///< Planted, but hard to tell from right ones: near its prediction, or of hardly seen features.
};

/// A log with planted measurements, with the truth for each closure and then for each observation.
template <int Dim>
struct Spoilt {
  Log<Dim> log;
  std::vector<Truth> truth;
};

/// The log with planted closures or identities. A planted measurement is wrong if it is more than 10 standard deviations from
/// the prediction by the clean map (Mahalanobis, by the covariances of both) and, for an observation, if its true and its given
/// name have two other right sightings each; otherwise it is undecided.
template <int Dim>
Spoilt<Dim> with_wrong_closures(const CleanMap<Dim>& clean, ClosurePolicy policy, std::size_t count, std::uint64_t seed);
template <int Dim>
Spoilt<Dim> with_wrong_identities(const CleanMap<Dim>& clean, double share, std::uint64_t seed);

/// The map that a method makes of a spoilt log.
template <int Dim>
struct RobustMap {
  Log<Dim> kept;  ///< The log without rejected measurements.
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
  double rms = 0.0;              ///< RMS distance of poses from the clean map (m).
  double chi2_ratio = 0.0;       ///< chi2 of the log's own measurements over its least one.
  std::size_t features_off = 0;  ///< Features more than 3 standard deviations from the clean map.

  double precision() const;
  double recall() const;
};

/// The RMS distance of the poses of two maps of the same log (m).
template <int Dim>
double rms_between(const Table<PoseIndex, Pose<Dim>>& a, const Table<PoseIndex, Pose<Dim>>& b);

/// The number of features more than 3 standard deviations from the clean map, by the covariances of that.
template <int Dim>
std::size_t count_features_off(const Table<FeatureIndex, Point<Dim>>& clean,
                               const Table<FeatureIndex, PointMatrix<Dim>>& covariances,
                               const Table<FeatureIndex, Point<Dim>>& features);

template <int Dim>
OutlierScore score(const CleanMap<Dim>& clean, const Spoilt<Dim>& spoilt, const RobustMap<Dim>& robust);

}  // namespace mapjoin::bench
