// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/robust/support/closure_support.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// Prior log-odds of a closure: nine in ten may be wrong.
const double kPriorOdds = std::log(1.0 / 9.0);
/// Bound on the evidence of odometry, or of a map, against a closure (log-odds).
constexpr double kMostAgainst = 20.0;
/// Odometry steps in a stretch, times the reach.
constexpr std::int32_t kStretch = 25;
/// Maximum number of odometry steps in a loop of two closures, times the reach.
constexpr std::int32_t kLongestLoop = 60;
/// Maximum number of samples of a cell, with which others are compared.
constexpr std::size_t kMostOfACell = kStretch;
/// The share of the closures, the best supported ones, whose loops give the scale if there are at least kLeastLoops.
constexpr double kBestShare = 0.05;
constexpr std::size_t kLeastLoops = 100;
/// The quantile of the squared mismatches of these loops that gives the scale: most of them may be of wrong closures that
/// support each other, but right ones agree most closely.
constexpr double kClosestShare = 0.1;

}  // namespace

template <int Dim>
ClosureSupport<Dim>::ClosureSupport(const OdometryChain<Dim>& chain, std::span<const PoseFactor<Dim>> closures,
                                    std::int32_t reach, const std::stop_token& stop)
    : chain_(chain), volume_(chain.volume()), reach_(reach), pairs_(closures.size()) {
  const double extent = chain.extent();
  for (const PoseFactor<Dim>& closure : closures) {
    const UncertainPose<Dim> measured = uncertain(completed(closure, extent));
    if (closure.base < closure.target) {
      closures_.push_back({closure.base, closure.target, measured});
    } else {
      closures_.push_back({closure.target, closure.base, inverse(measured)});
    }
  }
  sort_into_cells();
  parallel_for(pairs_.size(), [&](std::size_t k) {
    if (!stop.stop_requested()) pairs_[k] = pairs_of(k);
  });
}

template <int Dim>
void ClosureSupport<Dim>::sort_into_cells() {
  const std::int32_t stretch = reach_ * kStretch;
  const auto cell_of = [&](const Closure& c) { return std::pair(c.early.value / stretch, c.late.value / stretch); };
  for (std::size_t k = 0; k < closures_.size(); ++k) order_.push_back(k);
  std::ranges::stable_sort(order_, {}, [&](std::size_t k) { return cell_of(closures_[k]); });
  for (std::size_t k = 0; k < order_.size(); ++k) {
    Closure& closure = closures_[order_[k]];
    if (cells_.empty() || cells_.back() != cell_of(closure)) {
      cells_.push_back(cell_of(closure));
      first_.push_back(k);
    }
    closure.cell = cells_.size() - 1;
  }
  first_.push_back(order_.size());
  for (std::size_t cell = 0; cell < cells_.size(); ++cell)
    sample(std::span(order_).subspan(first_[cell], first_[cell + 1] - first_[cell]));
}

/// Moves the samples of a cell, which are spread over it, to its front.
template <int Dim>
void ClosureSupport<Dim>::sample(std::span<std::size_t> cell) {
  const std::size_t samples = std::min(cell.size(), kMostOfACell);
  for (std::size_t k = 0; k < samples; ++k) closures_[cell[k * cell.size() / samples]].is_sampled = true;
  std::stable_partition(cell.begin(), cell.end(), [&](std::size_t k) { return closures_[k].is_sampled; });
}

/// The pairs of a closure with all of larger index that form a loop with it, cell by cell; in full cells only if one of the two
/// is a sample.
template <int Dim>
std::vector<typename ClosureSupport<Dim>::Pair> ClosureSupport<Dim>::pairs_of(std::size_t closure) const {
  constexpr std::int32_t kCellsAround = kLongestLoop / kStretch + 1;
  std::vector<Pair> pairs;
  const Closure& a = closures_[closure];
  const auto [row, column] = cells_[a.cell];
  for (std::int32_t r = row - kCellsAround; r <= row + kCellsAround; ++r) {
    const auto begin = std::ranges::lower_bound(cells_, std::pair(r, column - kCellsAround));
    for (auto cell = begin; cell != cells_.end() && *cell <= std::pair(r, column + kCellsAround); ++cell) {
      const auto place = static_cast<std::size_t>(cell - cells_.begin());
      const std::size_t end = a.is_sampled ? first_[place + 1] : std::min(first_[place + 1], first_[place] + kMostOfACell);
      for (std::size_t k = first_[place]; k < end; ++k) {
        const Closure& b = closures_[order_[k]];
        const std::int32_t steps = std::abs(a.early - b.early) + std::abs(a.late - b.late);
        const bool is_loop = steps <= longest_loop() && chain_.is_tied(a.early, b.early) && chain_.is_tied(a.late, b.late);
        if (is_loop && order_[k] > closure) pairs.push_back({order_[k], evidence_of(loop(a, b))});
      }
    }
  }
  return pairs;
}

template <int Dim>
std::int32_t ClosureSupport<Dim>::longest_loop() const {
  return reach_ * kLongestLoop;
}

template <int Dim>
bool ClosureSupport<Dim>::compares_all() const {
  return longest_loop() >= 2 * static_cast<std::int64_t>(chain_.pose_count());
}

/// The loop from the early end of a to that of b, over b, back to the late end of a, and over a.
template <int Dim>
UncertainPose<Dim> ClosureSupport<Dim>::loop(const Closure& a, const Closure& b) const {
  const UncertainPose<Dim> over_b = compose(chain_.relative(a.early, b.early), b.measured);
  return compose(compose(over_b, chain_.relative(b.late, a.late)), inverse(a.measured));
}

template <int Dim>
Evidence ClosureSupport<Dim>::evidence_of(const UncertainPose<Dim>& loop) const {
  const PoseMatrix<Dim>& covariance = loop.covariance;
  const PoseVector<Dim> mismatch = local(Pose<Dim>{}, loop.mean);
  const bool is_turned_anyhow = covariance.diagonal().template tail<kRotationDof<Dim>>().minCoeff() > kSquaredTurn;
  if (!is_turned_anyhow) return evidence<kPoseDof<Dim>>(mismatch, covariance, volume_);
  return evidence<Dim>(Vector<Dim>(mismatch.template head<Dim>()), Matrix<Dim>(covariance.template topLeftCorner<Dim, Dim>()),
                       volume_ / kVolumeOfRotations<Dim>);
}

template <int Dim>
PriorOdds ClosureSupport<Dim>::prior(const UncertainPose<Dim>& mismatch, double scale) const {
  return {kPriorOdds + std::min(evidence_of(mismatch).at(scale, kMostAgainst), kMostOfAPair)};
}

template <int Dim>
std::vector<PriorOdds> ClosureSupport<Dim>::priors(double scale) const {
  std::vector<PriorOdds> priors(closures_.size(), {kPriorOdds});
  parallel_for(priors.size(), [&](std::size_t k) {
    const Closure& closure = closures_[k];
    if (!chain_.is_tied(closure.early, closure.late)) return;
    const auto loop = compose(chain_.relative(closure.early, closure.late), inverse(closure.measured));
    priors[k] = prior(loop, scale);
  });
  return priors;
}

template <int Dim>
template <typename F>
Agreements ClosureSupport<Dim>::agreements(const std::vector<PriorOdds>& priors, const F& evidence_of_pair) const {
  Agreements later(closures_.size());  // each pair once
  const auto group = [&](std::size_t k) { return static_cast<std::uint32_t>(closures_[k].cell); };
  parallel_for(closures_.size(), [&](std::size_t k) {
    if (priors[k].is_wrong) return;
    for (const Pair& pair : pairs_[k]) {
      if (priors[pair.other].is_wrong) continue;
      const auto evidence = static_cast<float>(evidence_of_pair(k, pair));
      later[k].push_back({static_cast<std::uint32_t>(pair.other), group(pair.other), evidence});
    }
  });
  Agreements all = later;
  for (std::size_t k = 0; k < later.size(); ++k) {
    for (const auto& a : later[k]) all[a.other].push_back({static_cast<std::uint32_t>(k), group(k), a.evidence});
  }
  parallel_for(all.size(), [&](std::size_t k) { std::ranges::stable_sort(all[k], {}, &Agreement::group); });
  return all;
}

template <int Dim>
std::vector<double> ClosureSupport<Dim>::odds(const std::vector<PriorOdds>& priors, double scale) const {
  const auto of_pair = [&](std::size_t, const Pair& pair) { return pair.evidence.at(scale, kMostOfAPair); };
  return odds_by_agreement(priors, agreements(priors, of_pair));
}

double odds_of_best(const std::vector<double>& odds) {
  return nth_largest(odds, odds.size() / kBestOneOf);
}

template <int Dim>
double ClosureSupport<Dim>::scale(const std::vector<double>& odds) const {
  if (odds.empty()) return 1.0;
  const double least =
      std::max(nth_largest(odds, static_cast<std::size_t>(kBestShare * static_cast<double>(odds.size()))), 2.0 * kMostOfAPair);
  const auto may_be_copies = [](const Closure& a, const Closure& b) { return a.early == b.early && a.late == b.late; };
  std::vector<double> mismatches;
  for (std::size_t k = 0; k < odds.size(); ++k) {
    if (odds[k] < least) continue;
    for (const auto& [other, evidence] : pairs_[k]) {
      const bool is_tested = evidence.rows == kPoseDof<Dim> && evidence.at(1.0, kMostOfAPair) > 0.0;
      if (!is_tested || odds[other] < least || may_be_copies(closures_[k], closures_[other])) continue;
      mismatches.push_back(evidence.squared_distance);
    }
  }
  if (mismatches.size() < kLeastLoops) return 1.0;
  const double closest = sample_quantile(std::move(mismatches), kClosestShare);
  return std::clamp(closest / chi_squared_quantile(kClosestShare, kPoseDof<Dim>), kLeastScale, 1.0);
}

template <int Dim>
std::vector<std::size_t> ClosureSupport<Dim>::set_sizes(const std::vector<bool>& is_asked, double scale) const {
  std::vector<Edge> edges;
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    if (!is_asked[k]) continue;
    for (const auto& [other, evidence] : pairs_[k]) {
      if (is_asked[other] && evidence.at(scale, kMostOfAPair) >= kMostOfAPair)
        edges.emplace_back(static_cast<Vertex>(k), static_cast<Vertex>(other));
    }
  }
  const std::vector<std::uint32_t> sets = components_of(make_graph(closures_.size(), edges));
  std::vector<std::size_t> sizes(sets.size());
  for (const std::uint32_t set : sets) ++sizes[set];
  std::vector<std::size_t> of_each(sets.size());
  for (std::size_t k = 0; k < sets.size(); ++k) of_each[k] = is_asked[k] ? sizes[sets[k]] : 0;
  return of_each;
}

template <int Dim>
template <typename F>
std::vector<double> ClosureSupport<Dim>::odds_among_closures(const F& evidence_of_pair) const {
  const std::vector<PriorOdds> priors(closures_.size(), {kPriorOdds});
  return odds_by_agreement(priors, agreements(priors, evidence_of_pair));
}

template <int Dim>
Table<PoseIndex, double> ClosureSupport<Dim>::evidence_for_steps(Voices voices) const {
  const double least = voices == Voices::kFor ? 0.0 : -kMostOfAPair;
  std::vector<double> right = odds_among_closures([&](std::size_t, const Pair& pair) { return std::max(least, said(pair)); });
  for (double& odds : right) odds = 1.0 / (1.0 + std::exp(-odds));
  Table<PoseIndex, double> evidence(chain_.pose_count() + 1, 0.0);  // at first its differences from step to step
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    for (const Pair& pair : pairs_[k]) {
      const Closure &a = closures_[k], &b = closures_[pair.other];
      const double of_pair = right[k] * right[pair.other] * said(pair);
      for (const auto& [first, last] : {std::minmax(a.early, b.early), std::minmax(a.late, b.late)}) {
        evidence[first + 1] += of_pair;
        evidence[last + 1] -= of_pair;
      }
    }
  }
  std::partial_sum(evidence.begin(), evidence.end(), evidence.begin());
  evidence.resize(chain_.pose_count());
  return evidence;
}

template <int Dim>
bool ClosureSupport<Dim>::goes_over(std::size_t closure, const Pair& pair, PoseIndex step) const {
  const Closure &a = closures_[closure], &b = closures_[pair.other];
  return (a.early < step) != (b.early < step) || (a.late < step) != (b.late < step);
}

template <int Dim>
double ClosureSupport<Dim>::sum_of_odds(std::optional<PoseIndex> left_out) const {
  double sum = 0.0;
  const auto said_elsewhere = [&](std::size_t k, const Pair& pair) {
    return left_out && goes_over(k, pair, *left_out) ? 0.0 : said(pair);
  };
  for (const double odds : odds_among_closures(said_elsewhere)) sum += std::max(0.0, odds);
  return sum;
}

template <int Dim>
SupportedClosures<Dim> supported(const OdometryChain<Dim>& chain, std::span<const PoseFactor<Dim>> closures,
                                 const std::stop_token& stop) {
  const auto within = [&](std::int32_t reach) {
    ClosureSupport<Dim> support(chain, closures, reach, stop);
    std::vector<PriorOdds> priors = support.priors(1.0);
    std::vector<double> odds = support.odds(priors, 1.0);
    return SupportedClosures<Dim>{std::move(support), std::move(priors), std::move(odds)};
  };
  const auto is_enough = [](const SupportedClosures<Dim>& some) { return odds_of_best(some.odds) > kLeastOdds; };
  SupportedClosures<Dim> shortest = within(1);
  if (closures.empty() || shortest.support.compares_all() || is_enough(shortest)) return shortest;
  for (std::int32_t reach = 2; !stop.stop_requested(); reach *= 2) {
    SupportedClosures<Dim> longer = within(reach);
    if (is_enough(longer)) return longer;
    if (longer.support.compares_all()) break;
  }
  return shortest;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                         \
  template class ClosureSupport<Dim>;                                                                    \
  template SupportedClosures<Dim> supported(const OdometryChain<Dim>&, std::span<const PoseFactor<Dim>>, \
                                            const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
