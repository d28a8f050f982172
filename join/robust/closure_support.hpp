// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Do closures agree with each other? Loops of odometry and two closures, before anything is solved.
//
// Two closures between the same two stretches of a drive make a loop with the odometry between their ends. Its mismatch v and
// covariance Σ say how much likelier it is that both are right than that one of them points anywhere in the volume V:
// e = ln(N(v; 0, Σ) V), the evidence of an Agreement.

#include <cstdint>
#include <mapjoin/join/robust/agreement.hpp>
#include <mapjoin/join/robust/odometry_chain.hpp>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The evidence that closures of a log give for each other.
template <int Dim>
class ClosureSupport {
 public:
  /// Compares all pairs, and no more of them once a stop is requested. `chain`, by the odometry of the same log, must stay.
  ClosureSupport(const OdometryChain<Dim>& chain, std::span<const PoseFactor<Dim>> closures, const std::stop_token& stop = {});

  /// What odometry alone says of each closure where all covariances are multiplied by `scale`.
  std::vector<PriorOdds> priors(double scale) const;
  /// What a map says of a closure by its mismatch with the map's prediction.
  PriorOdds prior(const UncertainPose<Dim>& mismatch, double scale) const;
  /// Logarithms of the odds that each closure is right, given `priors`.
  std::vector<double> odds(const std::vector<PriorOdds>& priors, double scale) const;
  /// By how much covariances are too cautious: the first decile of the squared mismatches of loops of two of the best supported
  /// closures over what it should be; 1 where there are too few loops, and where it is more.
  double scale(const std::vector<double>& odds) const;
  /// For each closure that is asked about the number of those, itself included, in its set; 0 for the others. Two are in one
  /// set where a chain of pairs joins them, the loop of each of which is evidence of kMostOfAPair, where covariances are
  /// multiplied by `scale`. Pairs that were not compared (of full cells) do not count.
  std::vector<std::size_t> set_sizes(const std::vector<bool>& is_asked, double scale) const;
  /// What closures say of each other: all of it, or only what speaks for them.
  enum class Voices : std::uint8_t { kAll, kFor };
  /// What closures say, by the loops that two of them make, of the steps of odometry to each pose: the sum of the evidence of
  /// the loops that the step has a part in, by the probabilities that both closures are right, whatever odometry alone says.
  /// Where a step is wrong, right closures speak against each other; by what speaks for them both may be right.
  Table<PoseIndex, double> evidence_for_steps(Voices voices) const;
  /// The sum of the odds (logarithms) of closures that are likelier right than wrong, by what closures say of each other; where
  /// the step of odometry to a pose is left out, all loops that it has a part in say nothing.
  double sum_of_odds(std::optional<PoseIndex> left_out = {}) const;

 private:
  struct Closure {
    PoseIndex early;              ///< The end that was driven first,
    PoseIndex late;               ///< and the other one,
    UncertainPose<Dim> measured;  ///< in its frame.
    std::size_t cell = 0;
    bool is_sampled = false;  ///< Others of a full cell are compared with it.
  };

  /// The evidence of the loop that a closure makes with a later one.
  struct Pair {
    std::size_t other;
    Evidence evidence;
  };

  void sort_into_cells();
  void sample(std::span<std::size_t> cell);
  std::vector<Pair> pairs_of(std::size_t closure) const;
  UncertainPose<Dim> loop(const Closure& a, const Closure& b) const;
  Evidence evidence_of(const UncertainPose<Dim>& loop) const;
  /// The evidence of a pair whose covariances are as they say.
  static double said(const Pair& pair) { return pair.evidence.at(1.0, kMostOfAPair); }
  /// Whether the loop of a closure with another one goes over the step of odometry to a pose.
  bool goes_over(std::size_t closure, const Pair& pair, PoseIndex step) const;
  /// `evidence_of_pair(closure, pair)`: a logarithm of odds.
  template <typename F>
  Agreements agreements(const std::vector<PriorOdds>& priors, const F& evidence_of_pair) const;
  /// Likewise, whatever odometry says of each.
  template <typename F>
  std::vector<double> odds_among_closures(const F& evidence_of_pair) const;

  const OdometryChain<Dim>& chain_;
  double volume_;
  std::vector<Closure> closures_;
  std::vector<std::pair<std::int32_t, std::int32_t>> cells_;  // ascending
  std::vector<std::size_t> first_;                            // of each cell in order_, and the end
  std::vector<std::size_t> order_;                            // closures cell by cell
  std::vector<std::vector<Pair>> pairs_;                      // by their earlier closure
};

}  // namespace mapjoin
