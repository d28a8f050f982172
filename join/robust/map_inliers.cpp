// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/linearise.hpp>
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

/// The covariance of a map; of what it does not determine large, but finite.
template <int Dim>
Eigen::MatrixXd covariance_of(const LocalMap<Dim>& map) {
  constexpr double kLeastShare = 1e-9;  // of the information of each coordinate
  Eigen::MatrixXd W = map.information;
  const double most = W.size() > 0 && W.diagonal().maxCoeff() > 0.0 ? W.diagonal().maxCoeff() : 1.0;
  for (Eigen::Index k = 0; k < W.rows(); ++k) W(k, k) += kLeastShare * (W(k, k) > 0.0 ? W(k, k) : most);
  return W.llt().solve(Eigen::MatrixXd::Identity(W.rows(), W.rows()));
}

/// By a covariance; nothing known where that is not positive definite.
template <int Size>
Matrix<Size> information_by(const Matrix<Size>& covariance) {
  return information_of_covariance<Size>(covariance).value_or(Matrix<Size>::Zero());
}

/// What a map says of pose `t` that it keeps, from the one before it or from its base.
template <int Dim>
PoseFactor<Dim> step_to(const LocalMap<Dim>& map, const Eigen::MatrixXd& covariance, std::size_t t) {
  constexpr int kDof = kPoseDof<Dim>;
  const Pose<Dim>& pose = map.pose_estimates[t];
  if (t == 0) return {map.base, map.poses[0], pose, information_by<kDof>(covariance.topLeftCorner<kDof, kDof>()), {}};
  const Pose<Dim>& before = map.pose_estimates[t - 1];
  const auto linear = linearise<Dim>(between(before, pose), before, pose);
  Eigen::Matrix<double, kDof, 2 * kDof> J;
  J << linear.J_base, linear.J_target;
  const auto both = covariance.block<2 * kDof, 2 * kDof>(map.row(t - 1), map.row(t - 1));
  return {map.poses[t - 1], map.poses[t], between(before, pose), information_by<kDof>(J * both * J.transpose()), {}};
}

/// A log of what each map of a set says of each of its features alone and of its poses, one after the other, and of what
/// stands on its own in the set.
template <int Dim>
struct TakenApart {
  Log<Dim> log;
  std::vector<std::size_t> maps;  ///< Of each observation of the log; the number of maps where it stands on its own.
};

template <int Dim>
TakenApart<Dim> taken_apart(const SubmapSet<Dim>& set) {
  TakenApart<Dim> apart;
  Log<Dim>& log = apart.log;
  log.source = set.source;
  log.poses = set.poses;
  log.features = set.features;
  log.graph = {set.graph.pose_factors, {}, {}, set.graph.fixed};
  using Sighting = std::pair<FeatureFactor<Dim>, std::size_t>;
  std::vector<Sighting> sightings;
  for (const auto& o : set.graph.feature_factors) sightings.emplace_back(o, set.graph.submaps.size());
  for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
    const LocalMap<Dim>& map = set.graph.submaps[m];
    const Eigen::MatrixXd covariance = covariance_of(map);
    for (std::size_t t = 0; t < map.poses.size(); ++t) log.graph.pose_factors.push_back(step_to(map, covariance, t));
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      const Eigen::Index row = map.row(map.poses.size() + f);
      const PointMatrix<Dim> information = information_by<Dim>(covariance.block<Dim, Dim>(row, row));
      sightings.push_back({{map.base, map.features[f], map.feature_estimates[f], information, {}}, m});
    }
  }
  // As put_in_order() has them.
  std::ranges::stable_sort(sightings, {}, [](const Sighting& s) { return std::pair(s.first.base == kWorld, s.first.base); });
  for (const auto& [observation, map] : sightings) {
    log.graph.feature_factors.push_back(observation);
    apart.maps.push_back(map);
  }
  put_in_order(log);
  return apart;
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
