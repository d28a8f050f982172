// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/whole.hpp>
#include <mapjoin/join/align/world.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
Piece<Dim> whole_of(const Network<Dim>& network) {
  Piece<Dim> whole;
  for (std::size_t p = 0; p < network.pose_count; ++p) {
    if (network.is_joined[p]) whole.poses.push_back(static_cast<Index>(p));
  }
  whole.factors = network.factors;
  for (const auto& condensed : network.maps) whole.factors.submaps.push_back(&condensed.map);

  std::vector<bool> is_seen(network.feature_count, false);
  for (const auto* map : whole.factors.submaps) {
    for (const Index feature : map->features) is_seen[static_cast<std::size_t>(feature)] = true;
  }
  for (const auto* selection : {&network.factors, &network.priors}) {
    for (const auto* o : selection->feature_factors) is_seen[static_cast<std::size_t>(o->target)] = true;
  }
  for (std::size_t f = 0; f < network.feature_count; ++f) {
    if (is_seen[f]) whole.features.push_back(static_cast<Index>(f));
  }
  whole.state.poses.resize(whole.poses.size());
  whole.state.features.resize(whole.features.size(), Point<Dim>::Zero());
  return whole;
}

template <int Dim>
State<Dim> composed_state(const Network<Dim>& network, const Piece<Dim>& whole, const Pose<Dim>& origin,
                          JoinedPieces<Dim> joined) {
  State<Dim> state = whole.state;
  // What pieces have in common is where the first of them says.
  for (auto piece = joined.pieces.rbegin(); piece != joined.pieces.rend(); ++piece) {
    place_in_world(network, origin, *piece);
    for (std::size_t p = 0; p < piece->poses.size(); ++p) {
      state.poses[static_cast<std::size_t>(place_of(whole.poses, piece->poses[p]))] = piece->state.poses[p];
    }
    for (std::size_t f = 0; f < piece->features.size(); ++f) {
      state.features[static_cast<std::size_t>(place_of(whole.features, piece->features[f]))] = piece->state.features[f];
    }
  }
  return state;
}

#define MAPJOIN_INSTANTIATE(Dim)                     \
  template Piece<Dim> whole_of(const Network<Dim>&); \
  template State<Dim> composed_state(const Network<Dim>&, const Piece<Dim>&, const Pose<Dim>&, JoinedPieces<Dim>);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
