// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/robust/closure_support.hpp>
#include <mapjoin/join/robust/gates.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/join/robust/repeated_odometry.hpp>
#include <mapjoin/join/robust/selection.hpp>
#include <mapjoin/join/robust/sighting_support.hpp>
#include <mapjoin/join/robust/truncated_join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numeric>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

/// The first map asks for odds (a logarithm) of this share of those of the twentieth best closure; every further map for a
/// fraction of those before, down to the least.
constexpr double kFirstShare = 0.6;
constexpr std::size_t kBest = 19;
constexpr double kOddsRatio = 3.0;
constexpr double kLeastOdds = 3.0;
/// Landing places of predictions.
constexpr std::size_t kMostPlaces = 50;
constexpr std::size_t kPosesAPlace = 8;
/// Steps of the join that a map starts from: truncated losses go on from there.
constexpr int kStartSteps = 1;
/// A log is first tried as it is where no more of its closures and observations are outvoted by the others, with so many steps.
constexpr std::ptrdiff_t kMostOutvoted = 20;
constexpr int kTrialSteps = 10;
/// Times that all closures are tried again, and that a map is settled anew without what it showed to be wrong.
constexpr int kMostTrials = 5;
constexpr int kMostSettles = 30;

/// The closures and observations of a log; at least 1.
template <int Dim>
double doubtful_count(const Log<Dim>& log) {
  return std::max(1.0, static_cast<double>(log.closures().size() + log.observations().size()));
}

/// What is known of a closure.
enum class Standing : std::uint8_t { kOpen, kKept, kDropped };

template <int Dim>
class InlierSearch {
 public:
  InlierSearch(const Log<Dim>& log, const RobustOptions& options, const std::stop_token& stop)
      : log_(log),
        options_(options),
        stop_(stop),
        chain_(log),
        support_(chain_, log.closures()),
        standing_(log.closures().size(), Standing::kOpen),
        chi2_(log.closures().size(), 0.0) {
    const double tail = (1.0 - options.confidence) / doubtful_count(log);
    widest_ = {chi_squared_upper_quantile(tail, kPoseDof<Dim>), chi_squared_upper_quantile(tail, Dim)};
  }

  Expected<Inliers<Log<Dim>>> all() {
    screen();
    if (const auto fits = fits_as_it_is(); !fits || *fits) return fits.map([&](bool) { return Inliers<Log<Dim>>{log_, {}}; });
    return take_in_by_odds().and_then([&] { return try_all_again(); }).map([&] { return inliers(); });
  }

 private:
  /// What odometry and closures say of each other, and observations of each other.
  void screen() {
    priors_ = support_.priors(1.0);
    odds_ = support_.odds(priors_, 1.0);
    scale_.closures = support_.scale(odds_);
    if (scale_.closures < 1.0) {
      priors_ = support_.priors(scale_.closures);
      odds_ = support_.odds(priors_, scale_.closures);
    }

    const auto is_outvoted = [](double odds) { return odds < -kLeastOdds; };
    const std::vector<double> odds = sighting_odds(chain_, log_);
    outvoted_ = std::ranges::count_if(odds_, is_outvoted) + std::ranges::count_if(odds, is_outvoted);
    std::vector<double> against(odds.size());
    for (std::size_t k = 0; k < odds.size(); ++k) {
      observations_count_.push_back(odds[k] > kLeastOdds);
      against[k] = -odds[k];
    }
    keep_one_of_each_feature(log_, against, observations_count_);
  }

  /// Whether every closure and observation passes its test where all count. Not tried where too many are outvoted.
  Expected<bool> fits_as_it_is() {
    if (outvoted_ > kMostOutvoted) return false;
    return start(log_).and_then([&](const Values<Dim>& start) -> Expected<bool> {
      TruncatedJoin<Dim> join(log_, start, {}, options_.engine);
      join.settle(stop_, kTrialSteps);
      if (stop_.stop_requested()) return tl::unexpected(interrupted());
      return join.is_tested() && !join.drop(widest_);
    });
  }

  /// Maps of ever more closures, from the best supported ones on. Each judges all closures.
  Expected<void> take_in_by_odds() {
    constexpr double kAnyOdds = -std::numeric_limits<double>::infinity();
    std::vector<std::size_t> made;
    for (double least = first_odds(); least != kAnyOdds;
         least = least > kLeastOdds ? std::max(least / kOddsRatio, kLeastOdds) : kAnyOdds) {
      const auto chosen = candidates([&](std::size_t k) { return standing_[k] == Standing::kOpen && odds_[k] > least; });
      if (chosen == made) continue;
      if (const auto done = make_map(chosen); !done) return done;
      made = chosen;
    }
    return {};
  }

  double first_odds() const {
    std::vector<double> descending = odds_;
    std::ranges::sort(descending, std::greater<>());
    if (descending.empty()) return kLeastOdds;
    return kFirstShare * descending[std::min(kBest, descending.size() - 1)];
  }

  /// Maps of all closures that the last one agrees with, whatever was said of them before, until there are no others.
  Expected<void> try_all_again() {
    std::vector<std::size_t> made = candidates([](std::size_t) { return false; });
    for (int trial = 0; trial < kMostTrials; ++trial) {
      last_gates_ = wide_gates();
      const auto chosen = candidates([&](std::size_t k) { return chi2_[k] < last_gates_->closures; });
      if (chosen == made && (trial > 0 || log_.observations().empty())) break;
      values_ = {};  // a better start
      if (const auto done = make_map(chosen); !done) return done;
      made = chosen;
    }
    return {};
  }

  /// Closures, ascending, for the next map: those kept, those that are `taken` and, where these leave the log in parts, the
  /// likeliest others that tie them together.
  template <typename F>
  std::vector<std::size_t> candidates(F&& taken) const {
    std::vector<bool> is_chosen(standing_.size());
    for (std::size_t k = 0; k < standing_.size(); ++k) is_chosen[k] = standing_[k] == Standing::kKept || taken(k);
    return tied_together(log_, odds_, std::move(is_chosen));
  }

  /// Makes the map of some closures, and lets it judge all.
  Expected<void> make_map(const std::vector<std::size_t>& chosen) {
    if (values_.poses.empty()) {
      std::vector<bool> sightings = observations_count_;
      keep_one_of_each_feature(log_, distances_of_observations(), sightings);
      auto started = start(selected(log_, chosen, sightings));
      if (!started && started.error().kind == ErrorKind::kBadInput) started = start(selected(log_, chosen, {}));
      if (!started) return tl::unexpected(started.error());
      values_ = std::move(*started);
    }
    TruncatedJoin<Dim> join(selected(log_, chosen, {}), values_, observations_count_, options_.engine);
    return settle(join).map([&] {
      values_ = join.system().estimate();
      observations_count_ = join.observations_count();
      observation_tests_.assign(join.observation_tests().begin(), join.observation_tests().end());
      judge(chosen, join);
    });
  }

  /// A first estimate, by a join.
  Expected<Values<Dim>> start(const Log<Dim>& log) const {
    RunOptions options = without_verdict();
    options.schedule = Schedule::kAligned;
    options.solver.max_iterations = kStartSteps;
    options.solver.engine = options_.engine;
    return solve(log, options, stop_).map([](auto&& joined) {
      return Values<Dim>{std::move(joined.map.poses), std::move(joined.map.features)};
    });
  }

  /// Brings a map to where all that counts passes its tests, and no observation that does not.
  Expected<void> settle(TruncatedJoin<Dim>& join) {
    join.graduate(gates(), stop_);
    bool are_readmitted = false;  // those that were dropped with what they suffered from
    for (int settles = 0; settles < kMostSettles; ++settles) {
      join.settle(stop_);
      if (stop_.stop_requested()) return tl::unexpected(interrupted());
      if (!join.is_tested()) {
        return bad_input(log_.source + ": the measurements that agree leave something free to move; without --robust " +
                         "the verdict names what is out of line");
      }
      scale_ = {scale_of(join.counting_closure_tests(), kPoseDof<Dim>), scale_of(join.counting_observation_tests(), Dim)};
      if (settles == 0 && join.readmit_observations(gates().observations)) {
        join.graduate(gates(), stop_);
      } else if (!join.drop(gates())) {
        if (are_readmitted || !join.readmit_observations(gates().observations)) break;
        are_readmitted = true;
      }
    }
    return {};
  }

  OfKinds gates() const { return last_gates_.value_or(narrow_gates()); }

  /// As closely as what is right fits.
  OfKinds narrow_gates() const { return {scale_.closures * widest_.closures, scale_.observations * widest_.observations}; }

  /// As widely as wrong closures allow.
  OfKinds wide_gates() const {
    std::vector<double> distances;
    for (std::size_t k = 0; k < standing_.size(); ++k) {
      if (standing_[k] != Standing::kKept) distances.push_back(chi2_[k]);
    }
    return {gate_among(std::move(distances), narrow_gates().closures, widest_.closures, kPoseDof<Dim>), widest_.observations};
  }

  void judge(const std::vector<std::size_t>& chosen, const TruncatedJoin<Dim>& join) {
    const std::size_t places = std::min(kMostPlaces, 1 + log_.poses.size() / kPosesAPlace);
    const Predictions<Dim> predictions(join.system(), join.marginals(), places);
    const double gate = narrow_gates().closures;
    parallel_for(standing_.size(), [&](std::size_t k) {
      const UncertainPose<Dim> mismatch = predictions.mismatch(log_.closures()[k]);
      const PoseVector<Dim> v = local(Pose<Dim>{}, mismatch.mean);
      const Eigen::LLT<PoseMatrix<Dim>> covariance(mismatch.covariance);
      const bool is_known = covariance.info() == Eigen::Success;
      chi2_[k] = is_known ? v.dot(covariance.solve(v)) : std::numeric_limits<double>::max();
      standing_[k] = chi2_[k] < gate ? Standing::kOpen : Standing::kDropped;
      priors_[k] = support_.prior(mismatch, scale_.closures);
    });
    for (std::size_t c = 0; c < chosen.size(); ++c) {
      chi2_[chosen[c]] = join.closure_tests()[c].chi2;  // which is exact
      if (join.counts(c)) standing_[chosen[c]] = Standing::kKept;
    }
    for (std::size_t k = 0; k < standing_.size(); ++k) {
      priors_[k].is_right = standing_[k] == Standing::kKept;
      priors_[k].is_wrong = standing_[k] == Standing::kDropped;
    }
    odds_ = support_.odds(priors_, scale_.closures);
  }

  Inliers<Log<Dim>> inliers() {
    keep_one_of_each_feature(log_, distances_of_observations(), observations_count_);
    Inliers<Log<Dim>> found;
    const auto reject = [&](PartKind kind, const auto& factor, double chi2, int rows, double widest) {
      const double tail = doubtful_count(log_) * chi_squared_upper_tail(chi2, rows);
      found.rejected.push_back({{kind, factor.base, factor.target, chi2, rows, std::min(1.0, tail)},
                                chi2 < widest ? WhyRejected::kCrowded : WhyRejected::kContradicted});
    };
    const std::vector<std::size_t> kept = kept_together();
    for (std::size_t k = 0; k < standing_.size(); ++k) {
      if (std::ranges::binary_search(kept, k)) continue;
      reject(PartKind::kClosure, log_.closures()[k], chi2_[k], kPoseDof<Dim>, widest_.closures);
    }
    for (std::size_t k = 0; k < observations_count_.size(); ++k) {
      if (observations_count_[k]) continue;
      reject(PartKind::kObservation, log_.observations()[k], observation_tests_[k].chi2, Dim, widest_.observations);
    }
    found.input = selected(log_, kept, observations_count_);
    put_in_order(found.input);
    return found;
  }

  /// The closures that are kept and, where these leave the log in parts, the nearest others that tie them together.
  std::vector<std::size_t> kept_together() const {
    std::vector<std::size_t> all(standing_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    std::vector<bool> is_kept(standing_.size());
    std::vector<double> nearness(standing_.size());
    for (std::size_t k = 0; k < standing_.size(); ++k) {
      is_kept[k] = standing_[k] == Standing::kKept;
      nearness[k] = -chi2_[k];
    }
    return tied_together(selected(log_, all, observations_count_), nearness, std::move(is_kept));
  }

  /// Squared, of each observation from its prediction; without a map all the same.
  std::vector<double> distances_of_observations() const {
    std::vector<double> distances(observations_count_.size());
    for (std::size_t k = 0; k < observation_tests_.size(); ++k) distances[k] = observation_tests_[k].chi2;
    return distances;
  }

  static Error interrupted() { return {ErrorKind::kInterrupted, "interrupted while rejecting"}; }

  const Log<Dim>& log_;
  const RobustOptions& options_;
  const std::stop_token& stop_;
  OdometryChain<Dim> chain_;
  ClosureSupport<Dim> support_;
  OfKinds widest_;  // what the confidence allows
  OfKinds scale_{1.0, 1.0};
  std::optional<OfKinds> last_gates_;  // once all are tried again
  std::ptrdiff_t outvoted_ = 0;
  std::vector<PriorOdds> priors_;
  std::vector<double> odds_;
  std::vector<Standing> standing_;
  std::vector<double> chi2_;  // of each closure's prediction
  Values<Dim> values_;        // of the last map; none to start afresh
  std::vector<bool> observations_count_;
  std::vector<PartTest> observation_tests_;
};

/// Without odometry that contradicts an earlier edge between the same two poses.
template <int Dim>
Inliers<Log<Dim>> without_contradicted_odometry(const Log<Dim>& log, double confidence) {
  Inliers<Log<Dim>> inliers{log, {}};
  const std::vector<RepeatedOdometry> repeated = repeated_odometry(log);
  const double count = doubtful_count(log) + static_cast<double>(repeated.size());
  const double widest = chi_squared_upper_quantile((1.0 - confidence) / count, kPoseDof<Dim>);
  std::vector<bool> is_rejected(log.graph.pose_factors.size());
  for (const auto& [edge, chi2] : repeated) {
    if (chi2 < widest) continue;
    const auto& factor = log.odometry()[edge];
    const double probability = std::min(1.0, count * chi_squared_upper_tail(chi2, kPoseDof<Dim>));
    inliers.rejected.push_back({{PartKind::kOdometry, factor.base, factor.target, chi2, kPoseDof<Dim>, probability}});
    is_rejected[edge] = true;
  }
  auto& factors = inliers.input.graph.pose_factors;
  factors.clear();
  for (std::size_t k = 0; k < is_rejected.size(); ++k) {
    if (!is_rejected[k]) factors.push_back(log.graph.pose_factors[k]);
  }
  return inliers;
}

}  // namespace

std::vector<std::string> RobustOptions::validate() const {
  if (confidence > 0.0 && confidence < 1.0) return {};
  return {"the confidence must be between 0 and 1"};
}

template <int Dim>
Expected<Inliers<Log<Dim>>> find_inliers(const Log<Dim>& log, const RobustOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (const auto connected = check_connected(log); !connected) return tl::unexpected(connected.error());
  Inliers<Log<Dim>> inliers = without_contradicted_odometry(log, options.confidence);
  return InlierSearch<Dim>(inliers.input, options, stop).all().map([&](Inliers<Log<Dim>>&& found) {
    found.rejected.insert(found.rejected.begin(), inliers.rejected.begin(), inliers.rejected.end());
    return std::move(found);
  });
}

template Expected<Inliers<Log<2>>> find_inliers(const Log<2>&, const RobustOptions&, const std::stop_token&);
template Expected<Inliers<Log<3>>> find_inliers(const Log<3>&, const RobustOptions&, const std::stop_token&);

}  // namespace mapjoin
