// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/robust/closure_support.hpp>
#include <mapjoin/join/robust/gates.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/join/robust/sighting_support.hpp>
#include <mapjoin/join/robust/truncated_join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// The first map is made of closures of this share of the odds (logarithm) that so many have at least. The odds asked for fall
/// by a ratio from map to map, to the least.
constexpr double kFirstShare = 0.6;
constexpr std::size_t kBest = 20;
constexpr double kOddsRatio = 3.0;
constexpr double kLeastOdds = 3.0;
/// What a map may say against a closure (logarithm of odds).
constexpr double kMostAgainst = 20.0;
/// Landing places of predictions.
constexpr std::size_t kMostPlaces = 100;
constexpr std::size_t kPosesAPlace = 8;
/// Steps of the join that the first map starts from: truncated losses go on from there.
constexpr int kStartSteps = 1;
/// A log is first tried as it is where no larger share of its closures is outvoted by the others.
constexpr double kMostOutvoted = 0.25;
/// Times that a map is settled anew without what it showed to be wrong.
constexpr int kMostDrops = 10;

/// The log with some of its closures, ascending, and some of its observations.
template <int Dim>
Log<Dim> selected(const Log<Dim>& log, const std::vector<std::size_t>& chosen, const std::vector<bool>& observation_counts) {
  Log<Dim> some = log;
  auto& observations = some.graph.feature_factors;
  observations.clear();
  for (std::size_t k = 0; k < log.graph.feature_factors.size(); ++k) {
    if (k >= observation_counts.size() || observation_counts[k]) observations.push_back(log.graph.feature_factors[k]);
  }
  auto& factors = some.graph.pose_factors;
  factors.assign(log.odometry().begin(), log.odometry().end());
  for (const std::size_t k : chosen) factors.push_back(log.closures()[k]);
  factors.insert(factors.end(), log.pose_priors().begin(), log.pose_priors().end());
  return some;
}

/// The closures that are chosen and, where these leave the log in parts, the best of the others that tie them together.
template <int Dim>
std::vector<std::size_t> tied_together(const Log<Dim>& log, const std::vector<double>& odds, std::vector<bool> is_chosen) {
  constexpr Vertex kWorldVertex = 0;
  const auto pose = [&](PoseIndex p) { return p == kWorld ? kWorldVertex : static_cast<Vertex>(1 + p.value); };
  const auto feature = [&](FeatureIndex f) { return static_cast<Vertex>(1 + log.poses.size()) + static_cast<Vertex>(f.value); };
  std::vector<Edge> edges;
  for (std::size_t k = 0; k < log.graph.pose_factors.size(); ++k) {
    const auto& o = log.graph.pose_factors[k];
    const std::size_t closure = k - log.odometry().size();  // past the end for odometry and priors
    if (closure >= is_chosen.size() || is_chosen[closure]) edges.emplace_back(pose(o.base), pose(o.target));
  }
  for (const auto& o : log.graph.feature_factors) edges.emplace_back(pose(o.base), feature(o.target));
  for (const auto& fixed : log.graph.fixed) edges.emplace_back(kWorldVertex, pose(fixed.pose));
  const std::size_t first_other = edges.size();
  std::vector<std::size_t> others;
  for (std::size_t k = 0; k < is_chosen.size(); ++k) {
    if (!is_chosen[k]) others.push_back(k);
  }
  std::ranges::stable_sort(others, std::greater<>(), [&](std::size_t k) { return odds[k]; });
  for (const std::size_t k : others) edges.emplace_back(pose(log.closures()[k].base), pose(log.closures()[k].target));
  for (const Reached& reached : spanning_forest(1 + log.poses.size() + log.features.size(), edges, {pose(0), kWorldVertex})) {
    if (reached.edge && *reached.edge >= first_other) is_chosen[others[*reached.edge - first_other]] = true;
  }
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < is_chosen.size(); ++k) {
    if (is_chosen[k]) chosen.push_back(k);
  }
  return chosen;
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
    const double p = 1.0 - (1.0 - options.confidence) / std::max(1.0, doubtful());
    widest_ = {chi_squared_quantile(p, kPoseDof<Dim>), chi_squared_quantile(p, Dim)};
  }

  Expected<Inliers<Dim>> all() {
    screen();
    if (const auto fits = fits_as_it_is(); !fits || *fits) return fits.map([&](bool) { return Inliers<Dim>{log_, {}}; });
    for (double least = first_odds(); least > -std::numeric_limits<double>::infinity(); least = next(least)) {
      if (const auto done = round(least); !done) return tl::unexpected(done.error());
    }
    is_last_ = true;
    if (const auto done = round(-std::numeric_limits<double>::infinity()); !done) return tl::unexpected(done.error());
    return inliers();
  }

 private:
  static double next(double least) {
    if (least <= kLeastOdds) return -std::numeric_limits<double>::infinity();
    return std::max(least / kOddsRatio, kLeastOdds);
  }

  /// What odometry and closures say of each other.
  void screen() {
    priors_ = support_.priors(1.0);
    odds_ = support_.odds(priors_, 1.0);
    scale_.closures = support_.scale(odds_);
    if (scale_.closures < 1.0) {
      priors_ = support_.priors(scale_.closures);
      odds_ = support_.odds(priors_, scale_.closures);
    }

    const std::vector<double> odds = sighting_odds(chain_, log_);
    std::vector<double> against(odds.size());
    for (std::size_t k = 0; k < odds.size(); ++k) {
      observations_count_.push_back(odds[k] > kLeastOdds);
      against[k] = -odds[k];
    }
    keep_one_of_each_feature(against);
  }

  /// Whether every closure and observation passes its test where all count. Not tried where too many closures are outvoted.
  Expected<bool> fits_as_it_is() {
    const auto outvoted = std::ranges::count_if(odds_, [](double odds) { return odds < 0.0; });
    if (static_cast<double>(outvoted) > kMostOutvoted * static_cast<double>(odds_.size())) return false;
    std::vector<std::size_t> all(odds_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    const std::vector<bool> screened = std::exchange(observations_count_, {});
    if (const auto done = start(all); !done) return tl::unexpected(done.error());
    TruncatedJoin<Dim> join(log_, std::exchange(values_, {}), {}, options_.engine);
    join.settle(stop_);
    observations_count_ = screened;
    if (stop_.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted while rejecting"});
    return join.is_tested() && !join.drop(widest_);
  }

  /// A feature of which no observation counts keeps the one that the least is against: there is nothing to contradict it.
  void keep_one_of_each_feature(const std::vector<double>& against) {
    constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
    Table<FeatureIndex, std::size_t> best(log_.features.size(), kNone);
    for (std::size_t k = 0; k < against.size(); ++k) {
      std::size_t& of_feature = best[log_.observations()[k].target];
      const auto weight = [&](std::size_t o) { return std::pair(!observations_count_[o], against[o]); };
      if (of_feature == kNone || weight(k) < weight(of_feature)) of_feature = k;
    }
    for (const std::size_t k : best) {
      if (k != kNone) observations_count_[k] = true;
    }
  }

  double first_odds() const {
    std::vector<double> descending = odds_;
    std::ranges::sort(descending, std::greater<>());
    if (descending.empty()) return kLeastOdds;
    return kFirstShare * descending[std::min(kBest, descending.size() - 1)];
  }

  /// Closures, ascending, for the next map: those kept, open ones of at least such odds and, where these leave the log in
  /// parts, the best others that tie them together.
  std::vector<std::size_t> candidates(double least) const {
    const double gate = is_last_ ? last_gates().closures : 0.0;
    std::vector<bool> is_chosen(standing_.size());
    for (std::size_t k = 0; k < standing_.size(); ++k) {
      const bool is_open = is_last_ ? chi2_[k] < gate : standing_[k] == Standing::kOpen && odds_[k] > least;
      is_chosen[k] = standing_[k] == Standing::kKept || is_open;
    }
    return tied_together(log_, odds_, std::move(is_chosen));
  }

  /// Makes the map of the candidates, and lets it judge all closures.
  Expected<void> round(double least) {
    const std::vector<std::size_t> chosen = candidates(least);
    if (!is_last_ && chosen == chosen_) return {};
    if (const auto done = start(chosen); !done) return done;
    TruncatedJoin<Dim> join(selected(log_, chosen, {}), values_, observations_count_, options_.engine);
    if (const auto done = settle(join); !done) return done;
    values_ = join.system().estimate();
    observations_count_ = join.observations_count();
    observation_tests_.assign(join.observation_tests().begin(), join.observation_tests().end());
    judge(chosen, join);
    chosen_ = chosen;
    return {};
  }

  /// Brings a map to where all that counts passes its tests, and no observation that does not.
  Expected<void> settle(TruncatedJoin<Dim>& join) {
    OfKinds gates = is_last_ ? last_gates() : this->gates();
    join.graduate(gates, stop_);
    for (int drops = 0; drops < kMostDrops; ++drops) {
      join.settle(stop_);
      if (stop_.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted while rejecting"});
      if (!join.is_tested()) {
        return bad_input(log_.source + ": the measurements that agree leave something free to move; without --robust " +
                         "the verdict names what is out of line");
      }
      scale_ = {scale_of(join.closure_tests(), kPoseDof<Dim>), scale_of(join.observation_tests(), Dim)};
      if (!is_last_) gates = this->gates();
      if (drops == 0 && join.readmit_observations(gates.observations)) {
        join.graduate(gates, stop_);
      } else if (!join.drop(gates)) {
        break;
      }
    }
    return {};
  }

  OfKinds gates() const { return {scale_.closures * widest_.closures, scale_.observations * widest_.observations}; }

  /// Those of the last round, which tries all again that was rejected.
  OfKinds last_gates() const {
    std::vector<double> tests;
    for (std::size_t k = 0; k < standing_.size(); ++k) {
      if (standing_[k] != Standing::kKept) tests.push_back(chi2_[k]);
    }
    return {gate_among(std::move(tests), gates().closures, widest_.closures, kPoseDof<Dim>), widest_.observations};
  }

  /// An estimate for the log: the last one, or a join of its own.
  Expected<void> start(const std::vector<std::size_t>& chosen) {
    if (!values_.poses.empty()) return {};
    RunOptions options = without_verdict();
    options.schedule = Schedule::kAligned;
    options.solver.max_iterations = kStartSteps;
    options.solver.engine = options_.engine;
    auto joined = solve(selected(log_, chosen, observations_count_), options, stop_);
    if (!joined && joined.error().kind == ErrorKind::kBadInput) joined = solve(log_, options, stop_);  // they hold too little
    if (!joined) return tl::unexpected(joined.error());
    values_ = {std::move(joined->map.poses), std::move(joined->map.features)};
    return {};
  }

  void judge(const std::vector<std::size_t>& chosen, const TruncatedJoin<Dim>& join) {
    const std::size_t places = std::min(kMostPlaces, 1 + log_.poses.size() / kPosesAPlace);
    const Predictions<Dim> predictions(join.system(), join.marginals(), places);
    const double gate = gates().closures;
    parallel_for(standing_.size(), [&](std::size_t k) {
      const UncertainPose<Dim> mismatch = predictions.mismatch(log_.closures()[k]);
      const PoseVector<Dim> v = local(Pose<Dim>{}, mismatch.mean);
      chi2_[k] = v.dot(mismatch.covariance.llt().solve(v));
      standing_[k] = chi2_[k] < gate ? Standing::kOpen : Standing::kDropped;
      priors_[k] = {-std::log(9.0) +
                    std::min(loop_evidence(mismatch, scale_.closures, support_.volume(), kMostAgainst), kMostOfAPair)};
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

  Inliers<Dim> inliers() {
    std::vector<double> against;
    for (const PartTest& test : observation_tests_) against.push_back(test.chi2);
    keep_one_of_each_feature(against);
    Inliers<Dim> found;
    const auto reject = [&](PartKind kind, const auto& factor, double chi2, int rows, double widest) {
      const double tail = doubtful() * chi_squared_upper_tail(chi2, rows);
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
    found.log = selected(log_, kept, observations_count_);
    return found;
  }

  double doubtful() const { return static_cast<double>(log_.closures().size() + log_.observations().size()); }

  const Log<Dim>& log_;
  const RobustOptions& options_;
  const std::stop_token& stop_;
  OdometryChain<Dim> chain_;
  ClosureSupport<Dim> support_;
  OfKinds widest_;  // what the confidence allows
  OfKinds scale_{1.0, 1.0};
  std::vector<PriorOdds> priors_;
  std::vector<double> odds_;
  std::vector<Standing> standing_;
  std::vector<double> chi2_;  // of each closure's prediction
  Values<Dim> values_;
  std::vector<bool> observations_count_;
  std::vector<PartTest> observation_tests_;
  std::vector<std::size_t> chosen_;  // of the last map
  bool is_last_ = false;
};

}  // namespace

std::vector<std::string> RobustOptions::validate() const {
  if (confidence > 0.0 && confidence < 1.0) return {};
  return {"the confidence must be between 0 and 1"};
}

template <int Dim>
Expected<Inliers<Dim>> find_inliers(const Log<Dim>& log, const RobustOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  return check_connected(log).and_then([&] { return InlierSearch<Dim>(log, options, stop).all(); });
}

template Expected<Inliers<2>> find_inliers(const Log<2>&, const RobustOptions&, const std::stop_token&);
template Expected<Inliers<3>> find_inliers(const Log<3>&, const RobustOptions&, const std::stop_token&);

}  // namespace mapjoin
