// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/robust/doubtful_odometry.hpp>
#include <mapjoin/join/robust/inlier_search.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/repeated_odometry.hpp>
#include <mapjoin/join/robust/robust_map.hpp>
#include <mapjoin/join/robust/truncated_join.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The first map takes closures with at least this share of the log-odds of the best.
constexpr double kFirstShare = 0.6;
/// The ratio of the numbers of closures of successive first maps, where odds tell little.
constexpr std::size_t kFirstGrowth = 3;
/// Maximum number of outvoted closures and observations with which a log is first tried as it is.
constexpr std::size_t kMostOutvoted = 20;

/// True if every closure and observation passes its test when all count, closures within the scale that their loops show.
/// False, without a trial, if too many are outvoted.
template <int Dim>
Expected<bool> fits_as_it_is(const Log<Dim>& log, const Screening<Dim>& screening, Engine engine, const std::stop_token& stop) {
  if (screening.outvoted > kMostOutvoted) return false;
  return started_map(log, engine, stop).and_then([&](const Values<Dim>& start) -> Expected<bool> {
    TruncatedJoin<Dim> join(log, start, {}, engine);
    join.settle(stop);
    if (stop.stop_requested()) return interrupted("rejecting");
    const OfKinds gates = screening.gates.narrow();
    return join.is_tested() && !join.drop_closures(gates.closures) && !join.drop_observations(gates.observations);
  });
}

/// The least log-odds of the closures of each first map, descending. If there are few closures, or the best are not supported,
/// odds tell little: maps of the best one, three, nine and so on (and of ties with them) are tried, and one of all.
std::vector<double> odds_of_first_maps(const std::vector<double>& odds) {
  if (odds.empty()) return {kLeastOdds};
  const double best = odds_of_best(odds);
  if (odds.size() >= kBestOneOf && best > kLeastOdds) return {std::max(kLeastOdds, kFirstShare * best)};
  std::vector<double> firsts;
  for (std::size_t count = 1; count < odds.size(); count *= kFirstGrowth) {
    const double least = nth_largest(odds, count - 1);
    if (firsts.empty() || least < firsts.back()) firsts.push_back(least);
  }
  firsts.push_back(-std::numeric_limits<double>::infinity());
  return firsts;
}

/// The log as it is if that fits, otherwise the result of the searches from all first maps that rejects the fewest; failed ones
/// are passed over if another one succeeds.
template <int Dim>
Expected<Inliers<Log<Dim>>> best_inliers(const Log<Dim>& log, const Screening<Dim>& screening, Engine engine,
                                         const std::stop_token& stop) {
  if (stop.stop_requested()) return interrupted("rejecting");
  const auto fits = fits_as_it_is(log, screening, engine, stop);
  if (!fits || *fits) return fits.map([&](bool) { return Inliers<Log<Dim>>{log, {}}; });
  Expected<Inliers<Log<Dim>>> best = tl::unexpected(Error{});
  for (const double first : odds_of_first_maps(screening.closures.odds)) {
    best = fewer_rejected<Dim>(std::move(best), search_inliers(log, screening, first, engine, stop));
    if (stop.stop_requested()) return interrupted("rejecting");
  }
  return best;
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
  const SearchOf<Dim> search = [&](const Log<Dim>& some, const Screening<Dim>& screening) {
    return best_inliers(some, screening, options.engine, stop);
  };
  auto found = options.odometry ? without_doubtful_odometry(inliers.input, options, search, stop)
                                : search(inliers.input, Screening<Dim>(inliers.input, options.confidence, stop));
  return std::move(found).map([&](Inliers<Log<Dim>>&& found) {
    found.rejected.insert(found.rejected.begin(), inliers.rejected.begin(), inliers.rejected.end());
    return std::move(found);
  });
}

template Expected<Inliers<Log<2>>> find_inliers(const Log<2>&, const RobustOptions&, const std::stop_token&);
template Expected<Inliers<Log<3>>> find_inliers(const Log<3>&, const RobustOptions&, const std::stop_token&);

}  // namespace mapjoin
