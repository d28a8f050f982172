// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Full SLAM with truncated losses: closures and observations that do not fit the others cost a constant, and no longer pull.

#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// One number for closures, one for observations of features.
struct OfKinds {
  double closures = 0.0;
  double observations = 0.0;
};

/// Gives an edge that does not measure all of a relative pose a share of 1e-9 of its largest information in every direction,
/// for where nothing else that counts measures the rest.
template <int Dim>
void complete_weakly(PoseFactor<Dim>& edge);

/// A log whose closures and observations are doubtful, its estimate, and which of them count. Closures, then observations, in
/// the order of the log, are its doubtful factors.
template <int Dim>
class TruncatedJoin {
 public:
  /// From the estimate `start` of all poses and features on. The poses of the log must hang together. Of observations those of
  /// `observations_count` count, or all where it is empty.
  TruncatedJoin(Log<Dim> log, const Values<Dim>& start, const std::vector<bool>& observations_count, Engine engine);
  TruncatedJoin(const TruncatedJoin&) = delete;
  TruncatedJoin& operator=(const TruncatedJoin&) = delete;

  /// Lets those count that cost less than their thresholds c², by graduated non-convexity: from a loss so wide that all that
  /// count pull, to one that has let go of what is far beyond c². What is kept near c² is for tests to drop.
  void graduate(const OfKinds& thresholds, const std::stop_token& stop);
  /// Minimises over those that count, and tests each doubtful factor against all others that count.
  void settle(const std::stop_token& stop);
  /// The same to first order by one Gauss-Newton step, whose factorisation serves the tests, too; settles where that would not
  /// lower chi2. marginals() are of the estimate before the step.
  void settle_by_a_step(const std::stop_token& stop);
  /// Whether the last settling had tests: not where those that count leave something free to move, or on a stop.
  bool is_tested() const { return marginals_.has_value(); }
  /// Lets those closures no longer count whose tests are beyond the threshold. Returns whether there were any.
  bool drop_closures(double threshold);
  /// The same of observations, but only of those at least half as far (in chi2) as the farthest.
  bool drop_observations(double threshold);
  /// Lets closures and observations count again whose tests are within their thresholds. Returns whether there were any.
  bool readmit(const OfKinds& thresholds);

  bool counts(std::size_t doubtful) const { return counts_[doubtful]; }
  std::vector<bool> observations_count() const;
  /// Those of closures, or of observations, that count: how closely what is right fits.
  std::vector<PartTest> counting_closure_tests() const { return counting_tests(0, closure_count()); }
  std::vector<PartTest> counting_observation_tests() const { return counting_tests(closure_count(), counts_.size()); }
  /// By the last settling, of each doubtful factor.
  std::span<const PartTest> closure_tests() const { return std::span(tests_).first(closure_count()); }
  std::span<const PartTest> observation_tests() const { return std::span(tests_).subspan(closure_count()); }
  const JoiningSystem<Dim>& system() const { return *system_; }
  const Marginals& marginals() const { return *marginals_; }

 private:
  std::size_t closure_count() const { return log_.closures().size(); }
  /// Lets doubtful factors begin to end no longer count whose tests are beyond the threshold.
  bool drop_beyond(double threshold, std::size_t begin, std::size_t end);
  std::vector<PartTest> counting_tests(std::size_t begin, std::size_t end) const;
  template <typename F>
  void for_each_doubtful(F&& f);
  void take_weak_priors(const Values<Dim>& start);
  void find_factors();
  void set_losses(const Loss& counting);
  /// Tests each doubtful factor at the optimum of what was linearised and factorised last; losses are reset.
  void test_all(const std::stop_token& stop);
  /// The cost of each doubtful factor that counts over its threshold; losses are reset.
  std::vector<double> excess(const OfKinds& thresholds);
  double largest_excess(const OfKinds& thresholds);

  Log<Dim> log_;
  SubmapGraph<Dim> graph_;
  std::optional<JoiningSystem<Dim>> system_;
  std::optional<Marginals> marginals_;
  std::vector<std::size_t> factors_;  // of the system, by doubtful factor
  std::vector<bool> counts_;
  std::vector<PartTest> tests_;
};

}  // namespace mapjoin
