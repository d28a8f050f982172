// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/robust/taken_apart.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/marginal_information.hpp>
#include <numeric>
#include <set>
#include <tuple>
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

/// A feature under a wrong name: of a local map, or observed on its own.
struct WrongFeature {
  std::size_t map = 0;  ///< The number of maps where it is observed on its own.
  Rejected rejected;
};

/// Takes features of maps, and observations that stand on their own, out of a set.
template <int Dim>
void reject(const std::vector<WrongFeature>& wrong, Inliers<SubmapSet<Dim>>& inliers) {
  FactorGraph<Dim>& graph = inliers.input.graph;
  std::set<std::tuple<std::size_t, PoseIndex, FeatureIndex>> names;
  for (const auto& [map, rejected] : wrong) {
    const bool is_of_map = map < graph.submaps.size();
    names.emplace(map, rejected.misfit.from, std::get<FeatureIndex>(rejected.misfit.to));
    inliers.rejected.push_back(rejected);
    inliers.rejected.back().misfit.kind = is_of_map ? PartKind::kMapFeature : PartKind::kObservation;
  }
  for (std::size_t m = 0; m < graph.submaps.size(); ++m) {
    LocalMap<Dim>& map = graph.submaps[m];
    map = without_features(map, [&](FeatureIndex f) { return names.contains({m, map.base, f}); });
  }
  std::erase_if(graph.feature_factors, [&](const auto& o) { return names.contains({graph.submaps.size(), o.base, o.target}); });
}

/// By the log that a set was taken apart to.
template <int Dim>
std::vector<WrongFeature> wrong_features(const TakenApart<Dim>& apart, const std::vector<Rejected>& rejected) {
  std::vector<WrongFeature> wrong;
  for (const Rejected& one : rejected) {
    if (one.misfit.kind == PartKind::kObservation) wrong.push_back({apart.maps[one.observation], one});
  }
  return wrong;
}

/// The map of the set that is farthest from the joined one in what a misfit names.
template <int Dim>
std::size_t farthest_map(const SubmapSet<Dim>& set, const GlobalMap<Dim>& joined, const Misfit& misfit) {
  const FeatureIndex feature = std::get<FeatureIndex>(misfit.to);
  std::size_t farthest = set.graph.submaps.size();
  double distance = -1.0;
  for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
    const LocalMap<Dim>& map = set.graph.submaps[m];
    const auto named = std::ranges::find(map.features, feature);
    if (map.base != misfit.from || named == map.features.end()) continue;
    const Point<Dim> predicted = transform_into(joined.poses[map.base], joined.features[feature]);
    const double off = (map.feature_estimates[static_cast<std::size_t>(named - map.features.begin())] - predicted).norm();
    if (off > distance) std::tie(farthest, distance) = std::pair(m, off);
  }
  return farthest;
}

/// What the verdict on a join names of features.
template <int Dim>
std::vector<WrongFeature> wrong_features(const SubmapSet<Dim>& set, const RunResult<Dim>& joined, double level) {
  std::vector<WrongFeature> wrong;
  for (const Misfit& misfit : joined.fit.misfits) {
    if (misfit.probability >= level) continue;
    if (misfit.kind == PartKind::kMapFeature) wrong.push_back({farthest_map(set, joined.map, misfit), {misfit}});
    if (misfit.kind == PartKind::kObservation) wrong.push_back({set.graph.submaps.size(), {misfit}});
  }
  return wrong;
}

}  // namespace

template <int Dim>
Expected<Inliers<SubmapSet<Dim>>> find_inliers(const SubmapSet<Dim>& set, const RobustOptions& options,
                                               const std::stop_token& stop) {
  RobustOptions half = options;  // of the doubt for the search, the other half for verdicts
  half.confidence = 0.5 * (1.0 + options.confidence);
  half.odometry = false;
  const TakenApart<Dim> apart = taken_apart(set);
  const auto found = find_inliers(apart.log, half, stop);
  if (!found) return tl::unexpected(found.error());
  Inliers<SubmapSet<Dim>> inliers{set, {}};
  reject(wrong_features(apart, found->rejected), inliers);
  RunOptions join;
  join.solver.engine = options.engine;
  for (int joins = 0; joins < kMostJoins; ++joins) {
    const auto joined = run(SubmapSet<Dim>(inliers.input), join, stop);
    if (!joined) return tl::unexpected(joined.error());
    const std::vector<WrongFeature> wrong = wrong_features(inliers.input, *joined, 1.0 - half.confidence);
    if (wrong.empty()) break;
    reject(wrong, inliers);
  }
  return inliers;
}

template Expected<Inliers<SubmapSet<2>>> find_inliers(const SubmapSet<2>&, const RobustOptions&, const std::stop_token&);
template Expected<Inliers<SubmapSet<3>>> find_inliers(const SubmapSet<3>&, const RobustOptions&, const std::stop_token&);

}  // namespace mapjoin
