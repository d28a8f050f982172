// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/robust/truncated_join.hpp>
#include <mapjoin/join/robust/weak_information.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Steps with all that count, before losses are truncated.
constexpr int kFirstSteps = 5;
/// Steps of a round of graduated non-convexity: the next loss asks for no more.
constexpr int kStepsARound = 2;
/// Graduated non-convexity ends before this share of the truncated loss: near the threshold, tests drop what does not fit, and
/// later maps take in what does.
constexpr double kEndShare = 0.6;
/// The relative decrease of chi2 at which an estimate is settled.
constexpr double kSettled = 1e-6;
/// Only observations with at least this share of the largest chi2 are dropped at once: an outlier pulls its feature away from
/// the inliers, which then seem wrong, too.
constexpr double kDroppedShare = 0.5;

}  // namespace

template <int Dim>
TruncatedJoin<Dim>::TruncatedJoin(Log<Dim> log, const Values<Dim>& start, const std::vector<bool>& observations_count,
                                  Engine engine)
    : log_(std::move(log)), counts_(log_.closures().size() + log_.observations().size(), true), tests_(counts_.size()) {
  std::copy(observations_count.begin(), observations_count.end(),
            counts_.begin() + static_cast<std::ptrdiff_t>(closure_count()));
  take_weak_priors(start);
  graph_ = submap_graph_of(log_, split(log_, {SplitRule::kPoses, 1.0}), {});
  PartialMap<Dim> joined_map = joined_map_of(graph_);
  joined_map.state = restricted(start, joined_map);
  system_.emplace(joined_map, gauge_of(graph_, joined_map), engine);
  find_factors();
}

template <int Dim>
void TruncatedJoin<Dim>::find_factors() {
  factors_ = places_among(system_->pose_factors(), log_.closures());
  for (const std::size_t place : places_among(system_->feature_factors(), log_.observations())) {
    factors_.push_back(system_->pose_factors().size() + place);
  }
}

/// Fixes the gauge if nothing else does, and weakly holds what the factors that count may leave undetermined: starts of
/// sessions, features, and directions that odometry does not measure.
template <int Dim>
void TruncatedJoin<Dim>::take_weak_priors(const Values<Dim>& start) {
  const bool is_held = log_.is_held();
  if (!is_held) log_.graph.fixed.push_back({0, start.poses.front()});
  const auto odometry = static_cast<std::ptrdiff_t>(log_.odometry().size());
  const PoseVector<Dim> weak = weak_information(log_);
  std::for_each(log_.graph.pose_factors.begin(), log_.graph.pose_factors.begin() + odometry,
                [&](PoseFactor<Dim>& edge) { complete_weakly(edge, weak); });
  for (const Session& session : log_.sessions) {
    if (session.begin == 0 && !is_held) continue;
    log_.graph.pose_factors.push_back({kWorld, session.begin, start.poses[session.begin], weak.asDiagonal(), {}});
  }
  Table<FeatureIndex, PointMatrix<Dim>> information(log_.features.size(), PointMatrix<Dim>::Zero());
  for (const auto& o : log_.observations()) {
    const PointMatrix<Dim> R = start.poses[o.base].rotation.matrix();
    information[o.target] += kWeakShare * R * o.information * R.transpose();
  }
  for (const FeatureIndex f : indices(information)) {
    log_.graph.feature_factors.push_back({kWorld, f, start.features[f], information[f], {}});
  }
}

/// Calls f(doubtful factor, its number, its kind) for each.
template <int Dim>
template <typename F>
void TruncatedJoin<Dim>::for_each_doubtful(F&& f) {
  std::size_t k = 0;
  const std::size_t first_closure = log_.odometry().size();
  for (std::size_t c = 0; c < closure_count(); ++c) f(log_.graph.pose_factors[first_closure + c], k++, &OfKinds::closures);
  const std::size_t observations = counts_.size() - closure_count();
  for (std::size_t o = 0; o < observations; ++o) f(log_.graph.feature_factors[o], k++, &OfKinds::observations);
}

template <int Dim>
void TruncatedJoin<Dim>::set_losses(const Loss& counting) {
  for_each_doubtful([&](auto& factor, std::size_t k, auto) { factor.loss = counts_[k] ? counting : Loss::dropped(); });
}

template <int Dim>
std::vector<double> TruncatedJoin<Dim>::excess(const OfKinds& thresholds) {
  std::vector<double> excess(counts_.size());
  const Values<Dim>& values = system_->estimate();
  set_losses({});
  for_each_doubtful([&]<typename Factor>(Factor& factor, std::size_t k, double OfKinds::*kind) {
    if (!counts_[k]) return;
    const Pose<Dim>& base = values.poses[factor.base];
    if constexpr (std::is_same_v<Factor, PoseFactor<Dim>>) {
      excess[k] = cost(factor, base, values.poses[factor.target]) / thresholds.*kind;
    } else {
      excess[k] = cost(factor, base, values.features[factor.target]) / thresholds.*kind;
    }
  });
  return excess;
}

template <int Dim>
double TruncatedJoin<Dim>::largest_excess(const OfKinds& thresholds) {
  const std::vector<double> excess = this->excess(thresholds);
  return excess.empty() ? 0.0 : std::ranges::max(excess);
}

template <int Dim>
void TruncatedJoin<Dim>::graduate(const OfKinds& thresholds, const std::stop_token& stop) {
  MinimiseOptions solver;
  solver.relative_chi2 = kSettled;
  solver.max_iterations = kFirstSteps;
  set_losses({});
  minimise(*system_, solver, stop);
  solver.max_iterations = kStepsARound;
  double share = first_share(largest_excess(thresholds));
  while (share < kEndShare && largest_excess(thresholds) > 1.0 && !stop.stop_requested()) {
    for_each_doubtful([&](auto& factor, std::size_t k, double OfKinds::*kind) {
      factor.loss = counts_[k] ? Loss::truncated(thresholds.*kind, share) : Loss::dropped();
    });
    minimise(*system_, solver, stop);
    share = sharper(share);
  }
  const std::vector<double> excess = this->excess(thresholds);
  for (std::size_t k = 0; k < counts_.size(); ++k) counts_[k] = counts_[k] && excess[k] < 1.0;
}

template <int Dim>
void TruncatedJoin<Dim>::settle(const std::stop_token& stop) {
  marginals_.reset();
  set_losses({});
  MinimiseOptions solver;
  solver.relative_chi2 = kSettled;
  minimise(*system_, solver, stop);
  system_->linearise();
  if (!system_->factorise(0.0)) test_all(stop);
}

template <int Dim>
void TruncatedJoin<Dim>::settle_by_a_step(const std::stop_token& stop) {
  marginals_.reset();
  set_losses({});
  const double chi2 = system_->linearise();
  if (system_->factorise(0.0)) return;
  const bool is_good = system_->try_step(system_->solve()) < chi2;
  if (!is_good) return settle(stop);
  test_all(stop);
  system_->accept();
}

template <int Dim>
void TruncatedJoin<Dim>::test_all(const std::stop_token& stop) {
  if (stop.stop_requested()) return;
  marginals_.emplace(system_->equations());
  LeaveOneOut<Dim> leave_one_out(*system_, system_->equations(), *marginals_);
  for_each_doubtful([](auto& factor, std::size_t, auto) { factor.loss = {}; });  // tests are of the measurements as they are
  leave_one_out.solve_for_weak(counting_closures(), stop);
  parallel_chunks(counts_.size(), kObservationsPerPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) tests_[k] = leave_one_out.test_whole(factors_[k], counts_[k]);
  });
}

template <int Dim>
std::vector<std::size_t> TruncatedJoin<Dim>::counting_closures() const {
  std::vector<std::size_t> factors;
  for (std::size_t k = 0; k < closure_count(); ++k) {
    if (counts_[k]) factors.push_back(factors_[k]);
  }
  return factors;
}

template <int Dim>
bool TruncatedJoin<Dim>::drop_beyond(double threshold, std::size_t begin, std::size_t end) {
  bool any = false;
  for (std::size_t k = begin; k < end; ++k) {
    if (!counts_[k] || tests_[k].chi2 < threshold) continue;
    counts_[k] = false;
    any = true;
  }
  return any;
}

template <int Dim>
bool TruncatedJoin<Dim>::drop_closures(double threshold) {
  return drop_beyond(threshold, 0, closure_count());
}

template <int Dim>
bool TruncatedJoin<Dim>::drop_farthest_closure(double threshold) {
  double farthest = threshold;
  std::optional<std::size_t> dropped;
  for (std::size_t k = 0; k < closure_count(); ++k) {
    if (!counts_[k] || tests_[k].chi2 < farthest) continue;
    farthest = tests_[k].chi2;
    dropped = k;
  }
  if (dropped) counts_[*dropped] = false;
  return dropped.has_value();
}

template <int Dim>
bool TruncatedJoin<Dim>::drop_observations(double threshold) {
  double worst = 0.0;
  for (const PartTest& test : counting_observation_tests()) worst = std::max(worst, test.chi2);
  return drop_beyond(std::max(threshold, kDroppedShare * worst), closure_count(), counts_.size());
}

template <int Dim>
bool TruncatedJoin<Dim>::readmit(const OfKinds& thresholds) {
  bool any = false;
  for (std::size_t k = 0; k < counts_.size(); ++k) {
    const double threshold = k < closure_count() ? thresholds.closures : thresholds.observations;
    const bool is_within = tests_[k].chi2 < threshold;
    if (counts_[k] || !is_within) continue;
    counts_[k] = true;
    any = true;
  }
  return any;
}

template <int Dim>
std::vector<PartTest> TruncatedJoin<Dim>::counting_tests(std::size_t begin, std::size_t end) const {
  std::vector<PartTest> tests;
  for (std::size_t k = begin; k < end; ++k) {
    if (counts_[k]) tests.push_back(tests_[k]);
  }
  return tests;
}

template <int Dim>
std::vector<bool> TruncatedJoin<Dim>::observations_count() const {
  return {counts_.begin() + static_cast<std::ptrdiff_t>(closure_count()), counts_.end()};
}

template class TruncatedJoin<2>;
template class TruncatedJoin<3>;

}  // namespace mapjoin
