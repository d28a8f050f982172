// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/robust/closure_judgement.hpp>
#include <mapjoin/join/robust/closure_support.hpp>
#include <mapjoin/join/robust/doubtful_odometry.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/repeated_odometry.hpp>
#include <mapjoin/join/robust/robust_map.hpp>
#include <mapjoin/join/robust/selection.hpp>
#include <mapjoin/join/robust/sighting_support.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/information.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// The first map asks for odds (a logarithm) of this share of those that one of so many closures surpasses; every further map
/// for a fraction of those before, down to the least.
constexpr double kFirstShare = 0.6;
constexpr std::size_t kOneSurpassesOf = 100;
constexpr double kOddsRatio = 3.0;
constexpr double kLeastOdds = 3.0;
/// A log is first tried as it is where no more of its closures and observations are outvoted by the others.
constexpr std::ptrdiff_t kMostOutvoted = 20;
/// Times that all closures are tried again: what the first time takes in may bear out others. Were they tried on and on, wrong
/// ones that lie near would come in one after the other, each borne out by those before.
constexpr int kMostTrials = 2;

/// The closures and observations of a log; at least 1.
template <int Dim>
double doubtful_count(const Log<Dim>& log) {
  return std::max(1.0, static_cast<double>(log.closures().size() + log.observations().size()));
}

template <int Dim>
class InlierSearch {
 public:
  InlierSearch(const Log<Dim>& log, const RobustOptions& options, const std::stop_token& stop)
      : log_(log),
        options_(options),
        stop_(stop),
        chain_(log),
        support_(chain_, log.closures(), stop),
        judged_{std::vector(log.closures().size(), Standing::kOpen), std::vector(log.closures().size(), 0.0), {}, {}} {
    const double tail = (1.0 - options.confidence) / doubtful_count(log);
    gates_.widest = {chi_squared_upper_quantile(tail, kPoseDof<Dim>), chi_squared_upper_quantile(tail, Dim)};
  }

  Expected<Inliers<Log<Dim>>> all() {
    screen();
    if (stop_.stop_requested()) return tl::unexpected(interrupted());
    if (const auto fits = fits_as_it_is(); !fits || *fits) return fits.map([&](bool) { return Inliers<Log<Dim>>{log_, {}}; });
    return take_in_by_odds().and_then([&] { return try_all_again(); }).map([&] { return inliers(); });
  }

 private:
  /// What odometry and closures say of each other, and observations of each other.
  void screen() {
    priors_ = support_.priors(1.0);
    odds_ = support_.odds(priors_, 1.0);
    gates_.scale.closures = support_.scale(odds_);
    if (gates_.scale.closures < 1.0) {
      priors_ = support_.priors(gates_.scale.closures);
      odds_ = support_.odds(priors_, gates_.scale.closures);
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
    return started_map(log_, options_.engine, stop_).and_then([&](const Values<Dim>& start) -> Expected<bool> {
      TruncatedJoin<Dim> join(log_, start, {}, options_.engine);
      join.settle(stop_);
      if (stop_.stop_requested()) return tl::unexpected(interrupted());
      return join.is_tested() && !join.drop(gates_.widest);
    });
  }

  /// Maps of ever more closures, from the best supported ones on. Each judges all closures.
  Expected<void> take_in_by_odds() {
    constexpr double kAnyOdds = -std::numeric_limits<double>::infinity();
    std::vector<std::size_t> made;
    for (double least = first_odds(); least != kAnyOdds;
         least = least > kLeastOdds ? std::max(least / kOddsRatio, kLeastOdds) : kAnyOdds) {
      const auto chosen = candidates([&](std::size_t k) { return judged_.standing[k] == Standing::kOpen && odds_[k] > least; });
      if (chosen == made) continue;
      if (const auto done = make_map(chosen); !done) return done;
      made = chosen;
    }
    return {};
  }

  double first_odds() const {
    if (odds_.empty()) return kLeastOdds;
    return std::max(kLeastOdds, kFirstShare * nth_largest(odds_, odds_.size() / kOneSurpassesOf));
  }

  /// Maps of what is kept and all other closures that pass the widest gate, and not by chance, whatever was said of them
  /// before: at most kMostTrials, fewer where there are no others, or only those of the last map.
  Expected<void> try_all_again() {
    std::vector<std::size_t> made;
    gates_.last = gates_.widest;
    for (int trial = 0; trial < kMostTrials; ++trial) {
      const std::vector<bool> fits = fits_beyond_chance(judged_, log_.closures(), gates_);
      const auto chosen = candidates([&](std::size_t k) { return fits[k]; });
      const bool are_others = chosen != made && chosen != candidates([](std::size_t) { return false; });
      if (!are_others && (trial > 0 || log_.observations().empty())) break;
      if (const auto done = make_map(chosen, From::kAnew); !done) return done;
      made = chosen;
    }
    return {};
  }

  /// Closures, ascending, for the next map: those kept, those that are `taken` and, where these leave the log in parts, the
  /// likeliest others that tie them together.
  template <typename F>
  std::vector<std::size_t> candidates(F&& taken) const {
    std::vector<bool> is_chosen(odds_.size());
    for (std::size_t k = 0; k < odds_.size(); ++k) is_chosen[k] = is_kept(k) || taken(k);
    return tied_together(log_, odds_, std::move(is_chosen));
  }

  /// Where a map starts: afresh, which takes longer, it ends in a better minimum.
  enum class From : std::uint8_t { kLastMap, kAnew };
  /// Makes the map of some closures, and lets it judge all.
  Expected<void> make_map(const std::vector<std::size_t>& chosen, From from = From::kLastMap) {
    if (from == From::kAnew || judged_.values.poses.empty()) {
      auto started = start(chosen);
      if (!started) return tl::unexpected(started.error());
      judged_.values = std::move(*started);
    }
    TruncatedJoin<Dim> join(selected(log_, chosen, {}), judged_.values, observations_count_, options_.engine);
    return settle(join, gates_, log_.source, stop_).and_then([&]() -> Expected<void> {
      observations_count_ = join.observations_count();
      observation_tests_.assign(join.observation_tests().begin(), join.observation_tests().end());
      judged_ = judge(log_, chosen, join, gates_, stop_);
      find_odds();
      if (stop_.stop_requested()) return tl::unexpected(interrupted());
      return {};
    });
  }

  Expected<Values<Dim>> start(const std::vector<std::size_t>& chosen) const {
    std::vector<bool> sightings = observations_count_;
    keep_one_of_each_feature(log_, distances_of_observations(), sightings);
    auto started = started_map(selected(log_, chosen, sightings), options_.engine, stop_);
    if (started || started.error().kind != ErrorKind::kBadInput) return started;
    return started_map(selected(log_, chosen, {}), options_.engine, stop_);
  }

  /// By what the last map says, and closures of each other.
  void find_odds() {
    for (std::size_t k = 0; k < priors_.size(); ++k) {
      if (!is_kept(k)) priors_[k] = support_.prior(judged_.mismatches[k], gates_.scale.closures);
      priors_[k].is_right = is_kept(k);
      priors_[k].is_wrong = judged_.standing[k] == Standing::kDropped;
    }
    odds_ = support_.odds(priors_, gates_.scale.closures);
  }

  bool is_kept(std::size_t closure) const { return judged_.standing[closure] == Standing::kKept; }

  Inliers<Log<Dim>> inliers() {
    keep_one_of_each_feature(log_, distances_of_observations(), observations_count_);
    Inliers<Log<Dim>> found;
    const auto reject = [&](PartKind kind, std::size_t k, const auto& factor, double chi2, int rows, double widest) {
      const double tail = doubtful_count(log_) * chi_squared_upper_tail(chi2, rows);
      found.rejected.push_back({{kind, factor.base, factor.target, chi2, rows, std::min(1.0, tail)},
                                chi2 < widest ? WhyRejected::kCrowded : WhyRejected::kContradicted,
                                k});
    };
    const std::vector<std::size_t> kept = kept_together();
    for (std::size_t k = 0; k < odds_.size(); ++k) {
      if (std::ranges::binary_search(kept, k)) continue;
      reject(PartKind::kClosure, k, log_.closures()[k], judged_.chi2[k], rows_of(k), gates_.widest.closures);
    }
    for (std::size_t k = 0; k < observations_count_.size(); ++k) {
      if (observations_count_[k]) continue;
      reject(PartKind::kObservation, k, log_.observations()[k], observation_tests_[k].chi2, Dim, gates_.widest.observations);
    }
    found.input = selected(log_, kept, observations_count_);
    put_in_order(found.input);
    return found;
  }

  /// Measured rows of a closure.
  int rows_of(std::size_t closure) const { return static_cast<int>(information_rank(log_.closures()[closure].information)); }

  /// The closures that are kept and, where these leave the log in parts, the nearest others that tie them together.
  std::vector<std::size_t> kept_together() const {
    std::vector<std::size_t> all(odds_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    std::vector<bool> are_kept(odds_.size());
    std::vector<double> nearness(odds_.size());
    for (std::size_t k = 0; k < odds_.size(); ++k) {
      are_kept[k] = is_kept(k);
      nearness[k] = -judged_.chi2[k];
    }
    return tied_together(selected(log_, all, observations_count_), nearness, std::move(are_kept));
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
  Gates gates_;
  std::ptrdiff_t outvoted_ = 0;
  std::vector<PriorOdds> priors_;
  std::vector<double> odds_;
  ClosureJudgement<Dim> judged_;  // by the last map; without values before the first one
  std::vector<bool> observations_count_;
  std::vector<PartTest> observation_tests_;
};

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
  const SearchOf<Dim> search = [&](const Log<Dim>& some) { return InlierSearch<Dim>(some, options, stop).all(); };
  auto found = options.odometry ? without_doubtful_odometry(inliers.input, options, search, stop) : search(inliers.input);
  return std::move(found).map([&](Inliers<Log<Dim>>&& found) {
    found.rejected.insert(found.rejected.begin(), inliers.rejected.begin(), inliers.rejected.end());
    return std::move(found);
  });
}

template Expected<Inliers<Log<2>>> find_inliers(const Log<2>&, const RobustOptions&, const std::stop_token&);
template Expected<Inliers<Log<3>>> find_inliers(const Log<3>&, const RobustOptions&, const std::stop_token&);

}  // namespace mapjoin
