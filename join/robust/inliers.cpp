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
#include <optional>
#include <ranges>
#include <utility>

namespace mapjoin {
namespace {

/// The first map is made of closures of this share of the odds (logarithm) that so many have at least. The odds asked for fall
/// by a ratio from map to map, to the least.
constexpr double kFirstShare = 0.6;
constexpr std::size_t kBest = 20;
constexpr double kOddsRatio = 5.0;
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
constexpr int kMostDrops = 10;

/// The measurements that may be rejected; at least 1.
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
    const double p = 1.0 - (1.0 - options.confidence) / doubtful_count(log);
    widest_ = {chi_squared_quantile(p, kPoseDof<Dim>), chi_squared_quantile(p, Dim)};
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

    const auto is_outvoted = [](double odds) { return odds < 0.0; };
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
      auto started = start(selected(log_, chosen, observations_count_));
      if (!started && started.error().kind == ErrorKind::kBadInput) started = start(log_);  // they hold too little
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
    for (int drops = 0; drops < kMostDrops; ++drops) {
      join.settle(stop_);
      if (stop_.stop_requested()) return tl::unexpected(interrupted());
      if (!join.is_tested()) {
        return bad_input(log_.source + ": the measurements that agree leave something free to move; without --robust " +
                         "the verdict names what is out of line");
      }
      scale_ = {scale_of(join.closure_tests(), kPoseDof<Dim>), scale_of(join.observation_tests(), Dim)};
      if (drops == 0 && join.readmit_observations(gates().observations)) {
        join.graduate(gates(), stop_);
      } else if (!join.drop(gates())) {
        break;
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
      chi2_[k] = v.dot(mismatch.covariance.llt().solve(v));
      standing_[k] = chi2_[k] < gate ? Standing::kOpen : Standing::kDropped;
      priors_[k] = support_.prior(mismatch, scale_.closures);
    });
    for (std::size_t c = 0; c < chosen.size(); ++c) {
      if (join.counts(c)) standing_[chosen[c]] = Standing::kKept;
    }
    for (std::size_t k = 0; k < standing_.size(); ++k) {
      priors_[k].is_right = standing_[k] == Standing::kKept;
      priors_[k].is_wrong = standing_[k] == Standing::kDropped;
    }
    odds_ = support_.odds(priors_, scale_.closures);
  }

  Inliers<Log<Dim>> inliers() {
    std::vector<double> against;
    for (const PartTest& test : observation_tests_) against.push_back(test.chi2);
    keep_one_of_each_feature(log_, against, observations_count_);
    Inliers<Log<Dim>> found;
    const auto reject = [&](PartKind kind, const auto& factor, double chi2, int rows, double widest) {
      const double tail = doubtful_count(log_) * chi_squared_upper_tail(chi2, rows);
      found.rejected.push_back({{kind, factor.base, factor.target, chi2, rows, std::min(1.0, tail)},
                                chi2 < widest ? WhyRejected::kCrowded : WhyRejected::kContradicted});
    };
    std::vector<std::size_t> kept;
    for (std::size_t k = 0; k < standing_.size(); ++k) {
      if (standing_[k] == Standing::kKept) {
        kept.push_back(k);
      } else {
        reject(PartKind::kClosure, log_.closures()[k], chi2_[k], kPoseDof<Dim>, widest_.closures);
      }
    }
    for (std::size_t k = 0; k < observations_count_.size(); ++k) {
      if (observations_count_[k]) continue;
      reject(PartKind::kObservation, log_.observations()[k], observation_tests_[k].chi2, Dim, widest_.observations);
    }
    found.input = selected(log_, kept, observations_count_);
    return found;
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
  const double count = doubtful_count(log);
  const double widest = chi_squared_quantile(1.0 - (1.0 - confidence) / count, kPoseDof<Dim>);
  for (const auto& [edge, chi2] : std::views::reverse(repeated)) {
    if (chi2 < widest) continue;
    auto& factors = inliers.input.graph.pose_factors;
    const auto& factor = factors[edge];
    const double probability = std::min(1.0, count * chi_squared_upper_tail(chi2, kPoseDof<Dim>));
    inliers.rejected.push_back({{PartKind::kOdometry, factor.base, factor.target, chi2, kPoseDof<Dim>, probability}});
    factors.erase(factors.begin() + static_cast<std::ptrdiff_t>(edge));
  }
  std::ranges::reverse(inliers.rejected);
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
