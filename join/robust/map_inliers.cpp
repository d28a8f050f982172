// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/taken_apart.hpp>
#include <mapjoin/model/information.hpp>
#include <numeric>
#include <set>
#include <utility>
#include <variant>

namespace mapjoin {
namespace {

/// The maximum number of searches by larger covariances, each by what the one before kept: the less that left out, the better.
constexpr int kMostAgain = 3;

/// The marginal information of some targets (ascending) of a map.
template <int Dim>
Eigen::MatrixXd information_of(const LocalMap<Dim>& map, const std::vector<std::size_t>& targets) {
  std::vector<Eigen::Index> rows;
  for (const std::size_t t : targets) {
    for (Eigen::Index row = map.row(t); row < map.row(t + 1); ++row) rows.push_back(row);
  }
  std::vector<Eigen::Index> all(static_cast<std::size_t>(map.information.rows()));
  std::iota(all.begin(), all.end(), Eigen::Index{0});
  std::vector<Eigen::Index> others;
  std::ranges::set_difference(all, rows, std::back_inserter(others));
  return marginal_information(map.information, rows, others);
}

/// The map without the features for whose places `is_rejected` is true.
template <typename F, int Dim>
LocalMap<Dim> without_features(const LocalMap<Dim>& map, F&& is_rejected) {
  LocalMap<Dim> rest = map;
  rest.features.clear();
  rest.feature_estimates.clear();
  std::vector<std::size_t> kept(map.poses.size());
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    if (is_rejected(f)) continue;
    rest.features.push_back(map.features[f]);
    rest.feature_estimates.push_back(map.feature_estimates[f]);
    kept.push_back(map.poses.size() + f);
  }
  if (rest.features.size() < map.features.size()) rest.information = information_of(map, kept);
  return rest;
}

/// Removes what was rejected of the log of a set from the set: features of maps, and observations that stand on their own.
template <int Dim>
Inliers<SubmapSet<Dim>> without(const std::vector<Rejected>& rejected, const TakenApart<Dim>& apart, SubmapSet<Dim> set) {
  Inliers<SubmapSet<Dim>> inliers{std::move(set), {}};
  FactorGraph<Dim>& graph = inliers.input.graph;
  const std::size_t no_map = graph.submaps.size();  // as TakenApart has it
  std::set<typename TakenApart<Dim>::Origin> origins;
  for (const Rejected& one : rejected) {
    if (one.misfit.kind != PartKind::kObservation) continue;
    const auto& origin = *origins.insert(apart.origins[one.observation]).first;
    inliers.rejected.push_back(one);
    if (origin.map < no_map) inliers.rejected.back().misfit.kind = PartKind::kMapFeature;
  }
  for (std::size_t m = 0; m < no_map; ++m) {
    graph.submaps[m] = without_features(graph.submaps[m], [&](std::size_t f) { return origins.contains({m, f}); });
  }
  std::vector<FeatureFactor<Dim>> kept;
  for (std::size_t k = 0; k < graph.feature_factors.size(); ++k) {
    if (!origins.contains({no_map, k})) kept.push_back(graph.feature_factors[k]);
  }
  graph.feature_factors = std::move(kept);
  return inliers;
}

/// The factors by which residuals of what is kept of a log are larger than its covariances say, kind by kind; 1 where they are
/// not, or nothing can be tested, and of priors, which no local map gives.
template <int Dim>
Inflation inflation_of(const Log<Dim>& kept, Engine engine, const std::stop_token& stop) {
  RunOptions options;
  options.solver.engine = engine;
  const auto result = run(kept, options, stop);
  Inflation inflation;
  if (!result) return inflation;
  for (const KindScale& kind : result->fit.kinds) {
    if (!kind.is_too_certain || kind.kind == PartKind::kPrior) continue;
    inflation.*inflation_of_kind(kind.kind) = std::min(std::sqrt(kind.scale), Inflation::kMost);
  }
  return inflation;
}

}  // namespace

template <int Dim>
Expected<Inliers<SubmapSet<Dim>>> find_inliers(const SubmapSet<Dim>& set, const RobustOptions& options,
                                               const std::stop_token& stop) {
  if (auto sound = check_content(set); !sound) return tl::unexpected(sound.error());
  RobustOptions of_log = options;
  of_log.odometry = false;  // all that relates poses is believed
  const TakenApart<Dim> apart = taken_apart(set);
  Log<Dim> judged = apart.log;
  auto found = find_inliers(judged, of_log, stop);
  for (int again = 0; found && again < kMostAgain; ++again) {
    const Inflation inflation = inflation_of(found->input, options.engine, stop);
    if (inflation == Inflation{}) break;
    inflate(inflation, judged);
    found = find_inliers(judged, of_log, stop);
  }
  if (!found) return tl::unexpected(found.error());
  return without(found->rejected, apart, set);
}

template Expected<Inliers<SubmapSet<2>>> find_inliers(const SubmapSet<2>&, const RobustOptions&, const std::stop_token&);
template Expected<Inliers<SubmapSet<3>>> find_inliers(const SubmapSet<3>&, const RobustOptions&, const std::stop_token&);

}  // namespace mapjoin
