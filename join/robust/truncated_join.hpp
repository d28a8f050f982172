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

/// A log whose closures and observations are doubtful, its estimate, and which of them count. Its doubtful factors are the
/// closures, then the observations, in the order of the log.
template <int Dim>
class TruncatedJoin {
 public:
  /// Starts from the estimate `start` of all poses and features. The poses of the log must be connected. The observations of
  /// `observations_count` count, or all if it is empty.
  TruncatedJoin(Log<Dim> log, const Values<Dim>& start, const std::vector<bool>& observations_count, Engine engine);
  TruncatedJoin(const TruncatedJoin&) = delete;
  TruncatedJoin& operator=(const TruncatedJoin&) = delete;

  /// Lets only factors that cost less than their thresholds c² count, by graduated non-convexity: from a loss so wide that all
  /// that count pull, to one that has let go of those far beyond c². Those kept near c² are for tests to drop.
  void graduate(const OfKinds& thresholds, const std::stop_token& stop);
  /// Minimises over the factors that count, and tests each doubtful factor against all others that count.
  void settle(const std::stop_token& stop);
  /// Settles to first order by one Gauss-Newton step, whose factorisation serves the tests, too; settles fully if the step
  /// would not lower chi2. marginals() are of the estimate before the step.
  void settle_by_a_step(const std::stop_token& stop);
  /// True if the last settling made tests: false on a stop, or if the factors that count leave something undetermined.
  bool is_tested() const { return marginals_.has_value(); }
  /// Drops the closures whose tests are beyond the threshold. True if there were any.
  bool drop_closures(double threshold);
  /// Drops the closure whose test is farthest beyond the threshold. True if there was one.
  bool drop_farthest_closure(double threshold);
  /// Drops the observations whose tests are beyond the threshold and at least half as far (in chi2) as the farthest. True if
  /// there were any.
  bool drop_observations(double threshold);
  /// Readmits closures and observations whose tests are within their thresholds. True if there were any.
  bool readmit(const OfKinds& thresholds);

  bool counts(std::size_t doubtful) const { return counts_[doubtful]; }
  std::vector<bool> observations_count() const;
  /// Tests of the closures, or of the observations, that count: how closely inliers fit.
  std::vector<PartTest> counting_closure_tests() const { return counting_tests(0, closure_count()); }
  std::vector<PartTest> counting_observation_tests() const { return counting_tests(closure_count(), counts_.size()); }
  /// Tests of all closures, or of all observations, by the last settling.
  std::span<const PartTest> closure_tests() const { return std::span(tests_).first(closure_count()); }
  std::span<const PartTest> observation_tests() const { return std::span(tests_).subspan(closure_count()); }
  const JoiningSystem<Dim>& system() const { return *system_; }
  const Marginals& marginals() const { return *marginals_; }

 private:
  std::size_t closure_count() const { return log_.closures().size(); }
  /// Drops the doubtful factors [begin, end) whose tests are beyond the threshold. True if there were any.
  bool drop_beyond(double threshold, std::size_t begin, std::size_t end);
  /// The factors of the system that are closures, and count.
  std::vector<std::size_t> counting_closures() const;
  std::vector<PartTest> counting_tests(std::size_t begin, std::size_t end) const;
  template <typename F>
  void for_each_doubtful(F&& f);
  void take_weak_priors(const Values<Dim>& start);
  void find_factors();
  void set_losses(const Loss& counting);
  /// Tests each doubtful factor at the optimum of the last linearisation and factorisation; losses are reset.
  void test_all(const std::stop_token& stop);
  /// The cost of each doubtful factor over its threshold, 0 if it does not count; losses are reset.
  std::vector<double> excess(const OfKinds& thresholds);
  double largest_excess(const OfKinds& thresholds);

  Log<Dim> log_;
  SubmapGraph<Dim> graph_;
  std::optional<JoiningSystem<Dim>> system_;
  std::optional<Marginals> marginals_;
  std::vector<std::size_t> factors_;  // numbers in the system, by doubtful factor
  std::vector<bool> counts_;
  std::vector<PartTest> tests_;
};

}  // namespace mapjoin
