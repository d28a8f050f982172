// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/leaf.hpp>
#include <numeric>

namespace mapjoin {

template <int Dim>
Leaves<Dim>::Leaves(const Network<Dim>& network)
    : network_(network),
      maps_(network.stretches.size(), nullptr),
      odometry_(network.stretches.size()),
      observations_(network.stretches.size()),
      joined_pose_count_(static_cast<std::size_t>(std::count(network.is_joined.begin(), network.is_joined.end(), true))) {
  auto map = network.maps.begin();
  for (std::size_t k = 0; k < network.stretches.size(); ++k) {
    const Stretch& stretch = network.stretches[k];
    if (stretch.is_map) maps_[k] = &(map++)->map;
    // What two stretches share is of the later one.
    stretch_of_.resize(static_cast<std::size_t>(stretch.begin - network.stretches.front().begin), static_cast<Index>(k) - 1);
    stretch_of_.resize(static_cast<std::size_t>(stretch.end - network.stretches.front().begin) + 1, static_cast<Index>(k));
  }
  for (const auto* o : network.factors.pose_factors) {
    const auto [first, last] = stretches_of(*o);
    if (first == last && !network.stretches[first].is_map) {
      odometry_[first].push_back(o);
    } else {
      closures_.push_back(o);
    }
  }
  for (const auto* o : network.factors.feature_factors) observations_[stretch_of(o->base)].push_back(o);
}

template <int Dim>
std::size_t Leaves<Dim>::stretch_of(Index pose) const {
  const Index last = static_cast<Index>(stretch_of_.size()) - 1;
  const Index place = std::clamp<Index>(pose - network_.stretches.front().begin, 0, last);
  return static_cast<std::size_t>(stretch_of_[static_cast<std::size_t>(place)]);
}

template <int Dim>
std::pair<std::size_t, std::size_t> Leaves<Dim>::stretches_of(const PoseObservation<Dim>& observation) const {
  const auto [low, high] = std::minmax(observation.base, observation.target);
  const std::size_t first = stretch_of(low);
  std::size_t last = stretch_of(high);
  // An end pose is of the stretch before, too.
  if (last > first && network_.stretches[last - 1].end == high) --last;
  return {first, last};
}

template <int Dim>
Piece<Dim> Leaves<Dim>::piece(std::size_t stretch) const {
  return maps_[stretch] ? map_piece(*maps_[stretch]) : span_piece(stretch);
}

template <int Dim>
Piece<Dim> Leaves<Dim>::map_piece(const LocalMap<Dim>& map) const {
  Piece<Dim> piece;
  piece.factors.submaps.push_back(&map);
  piece.poses.push_back(map.base);
  piece.poses.insert(piece.poses.end(), map.poses.begin(), map.poses.end());
  piece.state.poses.emplace_back();
  piece.state.poses.insert(piece.state.poses.end(), map.pose_estimates.begin(), map.pose_estimates.end());
  piece.features = map.features;
  std::sort(piece.features.begin(), piece.features.end());
  piece.state.features.resize(piece.features.size());
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    piece.state.features[static_cast<std::size_t>(place_of(piece.features, map.features[f]))] = map.feature_estimates[f];
  }
  return piece;
}

template <int Dim>
Piece<Dim> Leaves<Dim>::span_piece(std::size_t stretch) const {
  const Stretch& span = network_.stretches[stretch];
  Piece<Dim> piece;
  piece.poses.resize(static_cast<std::size_t>(span.end - span.begin) + 1);
  std::iota(piece.poses.begin(), piece.poses.end(), span.begin);
  piece.state.poses.resize(piece.poses.size());
  piece.factors = {odometry_[stretch], observations_[stretch], {}};

  std::vector<bool> known(piece.poses.size(), false);
  known[0] = true;
  for (const auto* o : piece.factors.pose_factors) {
    const auto base = static_cast<std::size_t>(o->base - span.begin);
    const auto target = static_cast<std::size_t>(o->target - span.begin);
    if (known[base] && !known[target]) piece.state.poses[target] = compose(piece.state.poses[base], o->measured);
    if (known[target] && !known[base]) piece.state.poses[base] = compose(piece.state.poses[target], inverse(o->measured));
    known[base] = known[target] = known[base] || known[target];
  }

  piece.features.reserve(piece.factors.feature_factors.size());
  for (const auto* o : piece.factors.feature_factors) piece.features.push_back(o->target);
  std::sort(piece.features.begin(), piece.features.end());
  piece.features.erase(std::unique(piece.features.begin(), piece.features.end()), piece.features.end());
  piece.state.features.resize(piece.features.size());
  std::vector<bool> seen(piece.features.size(), false);
  for (const auto* o : piece.factors.feature_factors) {
    const auto f = static_cast<std::size_t>(place_of(piece.features, o->target));
    if (!seen[f]) piece.state.features[f] = transform(pose_in(piece, o->base), o->measured);
    seen[f] = true;
  }
  return piece;
}

template class Leaves<2>;
template class Leaves<3>;

}  // namespace mapjoin
