// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A whole network as one piece in the World: what the last join starts from.

#include <mapjoin/join/align/piece.hpp>
#include <mapjoin/join/schedule.hpp>

namespace mapjoin {

/// All poses, features, maps and observations of a network, in its order, as one piece; its state is zero.
template <int Dim>
Piece<Dim> whole_of(const Network<Dim>& network);

/// The state of that piece by those that it was joined from: the tied ones, and those that only the World ties together. Where
/// the World says nothing of a piece, its first pose is at `origin`.
template <int Dim>
State<Dim> composed_state(const Network<Dim>& network, const Piece<Dim>& whole, const Pose<Dim>& origin,
                          JoinedPieces<Dim> joined);

}  // namespace mapjoin
