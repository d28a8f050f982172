// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/join/association/feature_candidates.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/cross_covariances.hpp>
#include <set>

namespace mapjoin {

template <int Dim>
PointMatrix<Dim> OpenFeatures<Dim>::covariance(FeatureIndex one, std::size_t place) const {
  const auto column = std::ranges::lower_bound(with_near, one) - with_near.begin();
  return covariances.template block<Dim, Dim>(static_cast<Eigen::Index>(place) * Dim, column * Dim).transpose();
}

template <int Dim>
FeatureCandidates<Dim>::FeatureCandidates(const FeatureEstimate<Dim>& estimate, const Identities& identities,
                                          const NeighbourDensity<Dim>& density, double gate)
    : estimate_(estimate),
      identities_(identities),
      density_(density),
      gate_(gate),
      tree_(estimate.covariances->state().features) {
  for (std::size_t f = 0; f < identities.feature_count(); ++f) {
    covariances_.push_back(estimate.scale * (*estimate.marginals)[estimate.covariances->variable(FeatureIndex(f))]);
    largest_ = std::max(largest_, covariances_.back().trace());
  }
}

/// The features seen by `map` or before it that could be the same as `feature`, ascending. The covariance of a difference is at
/// most twice the sum of those of its terms.
template <int Dim>
std::vector<FeatureIndex> FeatureCandidates<Dim>::near(FeatureIndex feature, std::size_t map, bool only_neighbours) const {
  std::vector<FeatureIndex> found;
  const Point<Dim>& position = estimate_.position(feature);
  const double own = covariances_[feature].trace();
  const auto consider = [&](FeatureIndex other) {
    const double bound = 2.0 * gate_ * (own + covariances_[other].trace());
    if (other == feature || estimate_.parts.of_feature[other] != estimate_.parts.of_feature[feature]) return;
    if ((estimate_.position(other) - position).squaredNorm() > bound) return;
    if (identities_.may_be_same(feature, other)) found.push_back(other);
  };
  if (only_neighbours) {
    for (std::size_t m = map == 0 ? 0 : map - 1; m <= map; ++m) std::ranges::for_each(identities_.features_in(m), consider);
  } else {
    const auto sees = [&](std::size_t s) { return identities_.sighting(s).map <= map; };
    for (const std::size_t place : tree_.within(position, std::sqrt(2.0 * gate_ * (own + largest_)))) {
      if (std::ranges::any_of(identities_.sightings_of(FeatureIndex(place)), sees)) consider(FeatureIndex(place));
    }
  }
  make_distinct(found);
  return found;
}

template <int Dim>
OpenFeatures<Dim> FeatureCandidates<Dim>::of_map(std::size_t map, bool only_neighbours) const {
  OpenFeatures<Dim> open;
  std::vector<std::vector<FeatureIndex>> near_to;
  for (const FeatureIndex feature : identities_.features_in(map)) {
    auto others = near(feature, map, only_neighbours);
    if (others.empty()) continue;
    open.features.push_back(feature);
    near_to.push_back(std::move(others));
  }
  open.with_near = open.features;
  for (const auto& others : near_to) open.with_near.insert(open.with_near.end(), others.begin(), others.end());
  make_distinct(open.with_near);
  const CrossCovariances covariances(estimate_.covariances->equations());
  open.covariances =
      estimate_.scale * covariances.between(estimate_.variables_of(open.features), estimate_.variables_of(open.with_near));
  const double per_deviation = density_.confusable_per_deviation();
  for (std::size_t k = 0; k < open.features.size(); ++k) {
    auto& candidates = open.candidates.emplace_back();
    for (const FeatureIndex other : near_to[k]) {
      const PointMatrix<Dim> C = open.covariance(other, k);
      const PointMatrix<Dim> S = covariances_[open.features[k]] + covariances_[other] - C - C.transpose();
      const Point<Dim> d = estimate_.position(other) - estimate_.position(open.features[k]);
      const Eigen::LLT<PointMatrix<Dim>> factor(S);
      const double d2 = Point<Dim>(factor.matrixL().solve(d)).squaredNorm();
      if (factor.info() != Eigen::Success || !(d2 <= gate_)) continue;  // S may not be finite
      // √det S by its factor: det S itself may overflow.
      candidates.push_back({other, per_deviation * factor.matrixLLT().diagonal().prod(), S});
    }
  }
  return open;
}

/// True if this is a local map, the one before it is one of the same part, and both see something.
template <int Dim>
bool FeatureCandidates<Dim>::follows_a_local_map(std::size_t map) const {
  if (map == 0 || !estimate_.is_local_map[map - 1] || !estimate_.is_local_map[map]) return false;
  const auto before = identities_.features_in(map - 1);
  const auto own = identities_.features_in(map);
  if (before.empty() || own.empty()) return false;
  return estimate_.parts.of_feature[before.front()] == estimate_.parts.of_feature[own.front()];
}

/// The features of a map and of the one before it that may be the same, ascending.
template <int Dim>
std::vector<FeatureIndex> FeatureCandidates<Dim>::unclear(std::size_t map) const {
  std::set<FeatureIndex> unclear;
  const OpenFeatures<Dim> open = of_map(map, true);
  for (std::size_t k = 0; k < open.features.size(); ++k) {
    if (identities_.sees(map - 1, open.features[k])) continue;
    for (const Candidate<Dim>& candidate : open.candidates[k]) {
      if (identities_.sees(map - 1, candidate.feature)) unclear.insert({candidate.feature, open.features[k]});
    }
  }
  return {unclear.begin(), unclear.end()};
}

/// Adds which features of one map another one sees, except those of `but` that it does not.
template <int Dim>
void FeatureCandidates<Dim>::add_trials(std::size_t of, std::size_t by, const std::vector<FeatureIndex>& but,
                                        std::vector<SightingTrial>& trials) const {
  for (const FeatureIndex feature : identities_.features_in(of)) {
    const bool is_seen = identities_.sees(by, feature);
    if (!is_seen && std::ranges::binary_search(but, feature)) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (const FeatureIndex other : identities_.features_in(by)) {
      if (other != feature) nearest = std::min(nearest, (estimate_.position(other) - estimate_.position(feature)).norm());
    }
    if (std::isfinite(nearest)) trials.emplace_back(nearest, is_seen);  // otherwise the map sees nothing else
  }
}

template <int Dim>
SightingChance FeatureCandidates<Dim>::sighting_chance() const {
  std::vector<std::vector<SightingTrial>> of_maps(identities_.map_count());
  parallel_for(of_maps.size(), [&](std::size_t map) {
    if (!follows_a_local_map(map)) return;
    const std::vector<FeatureIndex> unclear = this->unclear(map);
    add_trials(map - 1, map, unclear, of_maps[map]);
    add_trials(map, map - 1, unclear, of_maps[map]);
  });
  std::vector<SightingTrial> trials;
  double reach = 0.0;  // the farthest of a sighting
  for (const auto& some : of_maps) trials.insert(trials.end(), some.begin(), some.end());
  for (const auto& [distance, is_seen] : trials) reach = is_seen ? std::max(reach, distance) : reach;
  std::erase_if(trials, [reach](const auto& trial) { return trial.first > reach; });
  return SightingChance(std::move(trials));
}

template struct OpenFeatures<2>;
template struct OpenFeatures<3>;
template class FeatureCandidates<2>;
template class FeatureCandidates<3>;

}  // namespace mapjoin
