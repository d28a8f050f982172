// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <limits>
#include <mapjoin/join/robust/closure_judgement.hpp>
#include <mapjoin/join/robust/inlier_search.hpp>
#include <mapjoin/join/robust/selection.hpp>
#include <mapjoin/join/robust/truncated_join.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/information.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// The ratio of the least log-odds of one map to those of the next, down to kLeastOdds. Except for the last one a map is made
/// only if its new closures are more than kLeastGrowth of those of the map before.
constexpr double kOddsRatio = 3.0;
constexpr double kLeastGrowth = 0.05;
/// Times that all closures are tried again: those taken in the first time may support others. More trials would take in wrong
/// ones that lie near, one after the other, each supported by those before.
constexpr int kMostTrials = 2;

/// A search for the closures and observations that agree, from one first map on.
template <int Dim>
class InlierSearch {
 public:
  InlierSearch(const Log<Dim>& log, const Screening<Dim>& screening, Engine engine, const std::stop_token& stop)
      : log_(log),
        screening_(screening),
        engine_(engine),
        stop_(stop),
        gates_(screening.gates),
        priors_(screening.closures.priors),
        odds_(screening.closures.odds),
        judged_{std::vector(odds_.size(), Standing::kOpen), std::vector(odds_.size(), 0.0), {}, {}},
        observations_count_(screening.observations_count) {}

  /// Makes maps of ever more closures, from the best supported ones on, without those that would add hardly any. Each tests all
  /// closures.
  Expected<void> take_in_by_odds(double first) {
    std::vector<std::size_t> made;
    for (double least = first;; least = std::max(least / kOddsRatio, kLeastOdds)) {
      const auto chosen =
          candidates([&](std::size_t k) { return judged_.standing[k] == Standing::kOpen && odds_[k] >= least; });
      const auto fresh = std::ranges::count_if(chosen, [&](std::size_t k) { return !std::ranges::binary_search(made, k); });
      const bool has_grown = static_cast<double>(fresh) > kLeastGrowth * static_cast<double>(made.size());
      const bool is_last = least <= kLeastOdds;
      if (is_last ? chosen != made : has_grown) {
        if (const auto done = make_map(chosen); !done) return done;
        made = chosen;
      }
      if (is_last) return {};
    }
  }

  /// Flags kept closures to be doubted: a few wrong ones may bend the map so that more right ones are rejected. Takes the
  /// largest set of rejected closures that were as likely as those of the first map before there was one; the kept closures in
  /// smaller sets are doubted if all together they are fewer than that set.
  std::vector<bool> outnumbered(double first) const {
    std::vector<bool> are_kept(odds_.size());
    std::vector<bool> are_rivals(odds_.size());
    for (std::size_t k = 0; k < odds_.size(); ++k) {
      are_kept[k] = is_kept(k);
      are_rivals[k] = !are_kept[k] && screening_.closures.odds[k] >= std::max(first, kLeastOdds);
    }
    const double scale = screening_.gates.scale.closures;
    const std::vector<std::size_t> rivals = screening_.closures.support.set_sizes(are_rivals, scale);
    const std::size_t most = rivals.empty() ? 0 : std::ranges::max(rivals);
    const std::vector<std::size_t> kept = screening_.closures.support.set_sizes(are_kept, scale);
    std::vector<bool> are_doubted(odds_.size());
    for (std::size_t k = 0; k < odds_.size(); ++k) are_doubted[k] = are_kept[k] && kept[k] < most;
    const bool are_fewer = std::ranges::count(are_doubted, true) < static_cast<std::ptrdiff_t>(most);
    return are_fewer ? are_doubted : std::vector<bool>(odds_.size());
  }

  /// Begins again from a map of the kept closures without the doubted ones, which are used only if nothing else connects parts
  /// of the log.
  Expected<void> begin_again_without(const std::vector<bool>& are_doubted, double first) {
    std::vector<double> odds = screening_.closures.odds;
    std::vector<bool> are_believed(odds_.size());
    for (std::size_t k = 0; k < odds_.size(); ++k) {
      are_believed[k] = is_kept(k) && !are_doubted[k];
      if (are_doubted[k]) odds[k] = -std::numeric_limits<double>::infinity();
    }
    gates_ = screening_.gates;
    return make_map(tied_together(log_, odds, std::move(are_believed)), From::kAnew).and_then([&] {
      return take_in_by_odds(first);
    });
  }

  /// Makes maps of the kept closures and all others that pass the widest gate beyond chance, whatever their odds: at most
  /// kMostTrials, fewer if there are no others, or only those of the last map; at least one if there are observations.
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

  Inliers<Log<Dim>> inliers() {
    keep_one_of_each_feature(log_, distances_of_observations(), observations_count_);
    const std::vector<std::size_t> kept = kept_together();
    Inliers<Log<Dim>> found{selected(log_, kept, observations_count_), {}};
    put_in_order(found.input);
    for (std::size_t k = 0; k < odds_.size(); ++k) {
      if (!std::ranges::binary_search(kept, k)) found.rejected.push_back(rejected_closure(k));
    }
    for (std::size_t k = 0; k < observations_count_.size(); ++k) {
      if (!observations_count_[k]) found.rejected.push_back(rejected_observation(k));
    }
    return found;
  }

 private:
  /// The closures for the next map, ascending: the kept ones, those that are `taken` and, if these leave the log in parts, the
  /// likeliest others that connect them.
  template <typename F>
  std::vector<std::size_t> candidates(F&& taken) const {
    std::vector<bool> is_chosen(odds_.size());
    for (std::size_t k = 0; k < odds_.size(); ++k) is_chosen[k] = is_kept(k) || taken(k);
    return tied_together(log_, odds_, std::move(is_chosen));
  }

  /// The start of a map: the last map, or anew, which takes longer but ends in a better minimum.
  enum class From : std::uint8_t { kLastMap, kAnew };
  /// Makes the map of some closures, and tests all closures by it.
  Expected<void> make_map(const std::vector<std::size_t>& chosen, From from = From::kLastMap) {
    if (from == From::kAnew || judged_.values.poses.empty()) {
      auto started = start(chosen);
      if (!started) return tl::unexpected(started.error());
      judged_.values = std::move(*started);
    }
    TruncatedJoin<Dim> join(selected(log_, chosen, {}), judged_.values, observations_count_, engine_);
    return settle(join, gates_, log_.source, stop_).and_then([&]() -> Expected<void> {
      observations_count_ = join.observations_count();
      observation_tests_.assign(join.observation_tests().begin(), join.observation_tests().end());
      judged_ = judge(log_, chosen, join, gates_, stop_);
      find_odds();
      if (stop_.stop_requested()) return interrupted("rejecting");
      return {};
    });
  }

  Expected<Values<Dim>> start(const std::vector<std::size_t>& chosen) const {
    std::vector<bool> sightings = observations_count_;
    keep_one_of_each_feature(log_, distances_of_observations(), sightings);
    auto started = started_map(selected(log_, chosen, sightings), engine_, stop_);
    if (started || started.error().kind != ErrorKind::kBadInput) return started;
    return started_map(selected(log_, chosen, {}), engine_, stop_);
  }

  /// Finds the odds of closures by the last map and by their agreement with each other.
  void find_odds() {
    for (std::size_t k = 0; k < priors_.size(); ++k) {
      if (!is_kept(k)) priors_[k] = screening_.closures.support.prior(judged_.mismatches[k], gates_.scale.closures);
      priors_[k].is_right = is_kept(k);
      priors_[k].is_wrong = judged_.standing[k] == Standing::kDropped;
    }
    odds_ = screening_.closures.support.odds(priors_, gates_.scale.closures);
  }

  Rejected rejected_closure(std::size_t k) const {
    const PoseFactor<Dim>& closure = log_.closures()[k];
    const int rows = static_cast<int>(information_rank(closure.information));
    return rejected({PartKind::kClosure, closure.base, closure.target, judged_.chi2[k], rows}, gates_.widest.closures, k);
  }
  Rejected rejected_observation(std::size_t k) const {
    const FeatureFactor<Dim>& seen = log_.observations()[k];
    return rejected({PartKind::kObservation, seen.base, seen.target, observation_tests_[k].chi2, Dim},
                    gates_.widest.observations, k);
  }
  Rejected rejected(Misfit misfit, double widest, std::size_t place) const {
    misfit.probability = std::min(1.0, screening_.doubtful_count * chi_squared_upper_tail(misfit.chi2, misfit.rows));
    return {misfit, misfit.chi2 < widest ? WhyRejected::kCrowded : WhyRejected::kContradicted, place};
  }

  bool is_kept(std::size_t closure) const { return judged_.standing[closure] == Standing::kKept; }

  /// The kept closures and, if these leave the log in parts, the nearest others that connect them.
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

  /// The squared distance of each observation from its prediction; zeros before the first map.
  std::vector<double> distances_of_observations() const {
    std::vector<double> distances(observations_count_.size());
    for (std::size_t k = 0; k < observation_tests_.size(); ++k) distances[k] = observation_tests_[k].chi2;
    return distances;
  }

  const Log<Dim>& log_;
  const Screening<Dim>& screening_;
  Engine engine_;
  const std::stop_token& stop_;
  // By the last map; before the first one by the screening, with all closures open, no values, and no tests of observations.
  Gates gates_;
  std::vector<PriorOdds> priors_;
  std::vector<double> odds_;
  ClosureJudgement<Dim> judged_;
  std::vector<bool> observations_count_;
  std::vector<PartTest> observation_tests_;
};

}  // namespace

template <int Dim>
Expected<Inliers<Log<Dim>>> fewer_rejected(Expected<Inliers<Log<Dim>>> a, Expected<Inliers<Log<Dim>>> b) {
  const bool is_b = !a || (b && b->rejected.size() < a->rejected.size());
  return is_b ? std::move(b) : std::move(a);
}

template <int Dim>
Expected<Inliers<Log<Dim>>> search_inliers(const Log<Dim>& log, const Screening<Dim>& screening, double first_odds,
                                           Engine engine, const std::stop_token& stop) {
  InlierSearch<Dim> search(log, screening, engine, stop);
  if (const auto done = search.take_in_by_odds(first_odds); !done) return tl::unexpected(done.error());
  const auto ended = [](InlierSearch<Dim> some) { return some.try_all_again().map([&] { return some.inliers(); }); };
  const std::vector<bool> doubted = search.outnumbered(first_odds);
  auto found = ended(search);
  if (std::ranges::count(doubted, true) == 0) return found;
  auto again = search.begin_again_without(doubted, first_odds).and_then([&] { return ended(std::move(search)); });
  return fewer_rejected<Dim>(std::move(found), std::move(again));
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                 \
  template Expected<Inliers<Log<Dim>>> fewer_rejected(Expected<Inliers<Log<Dim>>>, Expected<Inliers<Log<Dim>>>); \
  template Expected<Inliers<Log<Dim>>> search_inliers(const Log<Dim>&, const Screening<Dim>&, double, Engine,    \
                                                      const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
