// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The agreement of closures with each other, by loops of odometry and two closures, before anything is solved.
//
// Two closures between the same two stretches of a drive form a loop with the odometry between their ends. The mismatch v of
// the loop and its covariance Σ give the log-odds e = ln(N(v; 0, Σ) V) that both are right, rather than that one of them points
// anywhere in the volume V: the evidence of an Agreement.

#include <cstdint>
#include <mapjoin/join/robust/support/agreement.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Log-odds above which the others support a closure or an observation; below the negative of this they are against it.
inline constexpr double kLeastOdds = 3.0;

/// One closure in so many is among the best.
inline constexpr std::size_t kBestOneOf = 100;

/// The log-odds that the best of some closures, one in kBestOneOf, surpass; the largest if there are fewer. There must be at
/// least one.
double odds_of_best(const std::vector<double>& odds);

/// The evidence that closures of a log give for each other.
template <int Dim>
class ClosureSupport {
 public:
  /// Compares all pairs whose loop has at most 60 · `reach` odometry steps, until a stop is requested. `chain`, by the odometry
  /// of the same log, must outlive this.
  ClosureSupport(const OdometryChain<Dim>& chain, std::span<const PoseFactor<Dim>> closures, std::int32_t reach,
                 const std::stop_token& stop = {});
  /// The number of odometry steps in the longest loop that is compared.
  std::int32_t longest_loop() const;
  /// True if no loop is too long to be compared.
  bool compares_all() const;

  /// Prior odds of each closure by odometry alone, with all covariances multiplied by `scale`.
  std::vector<PriorOdds> priors(double scale) const;
  /// Prior odds of a closure by its mismatch with the prediction of a map, with the covariance multiplied by `scale`.
  PriorOdds prior(const UncertainPose<Dim>& mismatch, double scale) const;
  /// Log-odds that each closure is right, given `priors`, with all covariances multiplied by `scale`.
  std::vector<double> odds(const std::vector<PriorOdds>& priors, double scale) const;
  /// The scale of covariances that are too cautious, between kLeastScale and 1: the first decile of the squared mismatches of
  /// loops of two of the best supported closures over that of chi-square; 1 if there are too few loops.
  double scale(const std::vector<double>& odds) const;
  /// The size of the set of each closure that is asked about, itself included; 0 for the others. Two closures are in one set if
  /// a chain of pairs connects them in which every loop is evidence of kMostOfAPair, with covariances multiplied by `scale`.
  /// Pairs that were not compared (in full cells) do not count.
  std::vector<std::size_t> set_sizes(const std::vector<bool>& is_asked, double scale) const;
  /// The evidence by which closures are found right: all of it, or only that in their favour.
  enum class Voices : std::uint8_t { kAll, kFor };
  /// The evidence of closures for the odometry step to each pose: the sum of the evidence of the loops of two closures that
  /// contain the step, weighted by the probabilities that both are right, whatever odometry alone says of them. If a step is
  /// wrong, right closures contradict each other; by the evidence in their favour alone both may be right.
  Table<PoseIndex, double> evidence_for_steps(Voices voices) const;
  /// The sum of the log-odds of closures that are likelier right than wrong, by their agreement alone. All loops that contain
  /// the odometry step to `left_out` are ignored.
  double sum_of_odds(std::optional<PoseIndex> left_out = {}) const;

 private:
  struct Closure {
    PoseIndex early;              ///< The earlier end.
    PoseIndex late;               ///< The later end.
    UncertainPose<Dim> measured;  ///< `late` in the frame of `early`.
    std::size_t cell = 0;
    bool is_sampled = false;  ///< Compared with all others in reach; the rest of a full cell, only with samples.
  };

  /// The evidence of the loop of a closure with another one of larger index.
  struct Pair {
    std::size_t other;
    Evidence evidence;
  };

  void sort_into_cells();
  void sample(std::span<std::size_t> cell);
  std::vector<Pair> pairs_of(std::size_t closure) const;
  UncertainPose<Dim> loop(const Closure& a, const Closure& b) const;
  Evidence evidence_of(const UncertainPose<Dim>& loop) const;
  /// The evidence of a pair, with covariances as they are.
  static double said(const Pair& pair) { return pair.evidence.at(1.0, kMostOfAPair); }
  /// True if the loop of a closure with another one contains the odometry step to a pose.
  bool goes_over(std::size_t closure, const Pair& pair, PoseIndex step) const;
  /// The agreements of closures that are not known to be wrong; `evidence_of_pair(closure, pair)` is a log-odds.
  template <typename F>
  Agreements agreements(const std::vector<PriorOdds>& priors, const F& evidence_of_pair) const;
  /// Log-odds that each closure is right by agreement alone, whatever odometry says of it; `evidence_of_pair` as of
  /// agreements().
  template <typename F>
  std::vector<double> odds_among_closures(const F& evidence_of_pair) const;

  const OdometryChain<Dim>& chain_;
  double volume_;
  std::int32_t reach_;
  std::vector<Closure> closures_;
  std::vector<std::pair<std::int32_t, std::int32_t>> cells_;  // ascending
  std::vector<std::size_t> first_;                            // begin of each cell in order_, and the end
  std::vector<std::size_t> order_;                            // closures cell by cell
  std::vector<std::vector<Pair>> pairs_;                      // by the smaller index of the two
};

/// The support of closures by each other, and what follows from it.
template <int Dim>
struct SupportedClosures {
  ClosureSupport<Dim> support;
  std::vector<PriorOdds> priors;  ///< Prior odds of each closure.
  std::vector<double> odds;       ///< Log-odds of each closure.
};

/// The support of closures over loops that are just long enough for the best to be supported: longer ones in a log with many
/// poses from closure to closure. Over the shortest ones if none do. The odds are by covariances as they are. `chain` must
/// outlive it.
template <int Dim>
SupportedClosures<Dim> supported(const OdometryChain<Dim>& chain, std::span<const PoseFactor<Dim>> closures,
                                 const std::stop_token& stop);

}  // namespace mapjoin
