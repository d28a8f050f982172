// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/marginal_information.hpp>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <variant>

namespace mapjoin {
namespace {

/// Joins whose verdicts are asked for more that is wrong.
constexpr int kMostJoins = 10;

/// What a map says of some of its targets, ascending, whatever the others are.
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

/// A log of what each map says of each of its poses and features alone, and of what stands on its own in the set.
template <int Dim>
Log<Dim> taken_apart(const SubmapSet<Dim>& set) {
  Log<Dim> log;
  log.source = set.source;
  log.poses = set.poses;
  log.features = set.features;
  log.graph = {set.graph.pose_factors, set.graph.feature_factors, {}, set.graph.fixed};
  for (const LocalMap<Dim>& map : set.graph.submaps) {
    const std::size_t poses = map.poses.size();
    for (std::size_t t = 0; t < poses; ++t) {
      log.graph.pose_factors.push_back({map.base, map.poses[t], map.pose_estimates[t], information_of(map, {t}), {}});
    }
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      log.graph.feature_factors.push_back(
          {map.base, map.features[f], map.feature_estimates[f], information_of(map, {poses + f}), {}});
    }
  }
  put_in_order(log);
  return log;
}

/// The map without some of its features.
template <typename F, int Dim>
LocalMap<Dim> without_features(const LocalMap<Dim>& map, F&& is_rejected) {
  LocalMap<Dim> rest = map;
  rest.features.clear();
  rest.feature_estimates.clear();
  std::vector<std::size_t> kept(map.poses.size());
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    if (is_rejected(map.features[f])) continue;
    rest.features.push_back(map.features[f]);
    rest.feature_estimates.push_back(map.feature_estimates[f]);
    kept.push_back(map.poses.size() + f);
  }
  if (rest.features.size() < map.features.size()) rest.information = information_of(map, kept);
  return rest;
}

/// Takes features of maps, and observations that stand on their own, out of a set; what else is named is kept.
template <int Dim>
void reject(std::span<const Rejected> named, Inliers<SubmapSet<Dim>>& inliers) {
  using Sighting = std::pair<PoseIndex, FeatureIndex>;
  std::set<Sighting> wrong;
  for (const auto& [misfit, why] : named) {
    if (const auto* feature = std::get_if<FeatureIndex>(&misfit.to)) wrong.emplace(misfit.from, *feature);
  }
  std::set<Sighting> of_maps;
  for (LocalMap<Dim>& map : inliers.input.graph.submaps) {
    for (const FeatureIndex f : map.features) of_maps.emplace(map.base, f);
    map = without_features(map, [&](FeatureIndex f) { return wrong.contains({map.base, f}); });
  }
  std::erase_if(inliers.input.graph.feature_factors, [&](const auto& o) { return wrong.contains({o.base, o.target}); });
  for (Rejected rejected : named) {
    const auto* feature = std::get_if<FeatureIndex>(&rejected.misfit.to);
    if (feature == nullptr) continue;
    const bool is_of_map = of_maps.contains({rejected.misfit.from, *feature});
    rejected.misfit.kind = is_of_map ? PartKind::kMapFeature : PartKind::kObservation;
    inliers.rejected.push_back(rejected);
  }
}

/// What the verdict on a join names of features.
std::vector<Rejected> misfits_of_features(const GoodnessOfFit& fit, double confidence) {
  std::vector<Rejected> named;
  for (const Misfit& misfit : fit.misfits) {
    const bool is_of_feature = misfit.kind == PartKind::kMapFeature || misfit.kind == PartKind::kObservation;
    if (is_of_feature && misfit.probability < 1.0 - confidence) named.push_back({misfit});
  }
  return named;
}

}  // namespace

template <int Dim>
Expected<Inliers<SubmapSet<Dim>>> find_inliers(const SubmapSet<Dim>& set, const RobustOptions& options,
                                               const std::stop_token& stop) {
  const auto found = find_inliers(taken_apart(set), options, stop);
  if (!found) return tl::unexpected(found.error());
  Inliers<SubmapSet<Dim>> inliers{set, {}};
  reject(found->rejected, inliers);
  RunOptions join;
  join.solver.engine = options.engine;
  for (int joins = 0; joins < kMostJoins; ++joins) {
    const auto joined = run(SubmapSet<Dim>(inliers.input), join, stop);
    if (!joined) return tl::unexpected(joined.error());
    const std::vector<Rejected> named = misfits_of_features(joined->fit, options.confidence);
    if (named.empty()) break;
    reject(named, inliers);
  }
  return inliers;
}

template Expected<Inliers<SubmapSet<2>>> find_inliers(const SubmapSet<2>&, const RobustOptions&, const std::stop_token&);
template Expected<Inliers<SubmapSet<3>>> find_inliers(const SubmapSet<3>&, const RobustOptions&, const std::stop_token&);

}  // namespace mapjoin
