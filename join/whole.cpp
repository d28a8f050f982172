// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <mapjoin/join/placement.hpp>
#include <mapjoin/join/whole.hpp>
#include <mapjoin/join/world.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
Piece<Dim> whole_of(const Network<Dim>& network, const Pose<Dim>& origin, JoinedPieces<Dim> joined) {
  for (auto& piece : joined.pieces) place_in_world(network, origin, piece);
  Piece<Dim> whole = std::move(joined.pieces.front());
  for (std::size_t k = 1; k < joined.pieces.size(); ++k) whole = merged(whole, joined.pieces[k], Pose<Dim>{});
  for (const auto* closure : joined.pending) whole.pose_observations.push_back(closure);
  // Pieces that met late are out of order; the maps are members of one vector, so that addresses give the network's order.
  std::sort(whole.maps.begin(), whole.maps.end(), std::less<>());
  return whole;
}

template Piece<2> whole_of(const Network<2>&, const Pose<2>&, JoinedPieces<2>);
template Piece<3> whole_of(const Network<3>&, const Pose<3>&, JoinedPieces<3>);

}  // namespace mapjoin
