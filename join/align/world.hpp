// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the World says of a piece: where it stands, and what holds it still.

#include <mapjoin/join/align/piece.hpp>
#include <vector>

namespace mapjoin {

/// What holds a piece still.
template <int Dim>
struct Gauge {
  std::vector<Index> held;  ///< Places of poses that have no columns.
  FactorSelection<Dim> priors;
};

/// Moves the piece as a whole into the World's frame: by its fixed poses and priors or, without any position among them, its
/// first pose to `origin`.
template <int Dim>
void place_in_world(const Network<Dim>& network, const Pose<Dim>& origin, Piece<Dim>& piece);

/// What holds the piece: fixed poses and priors, else its first pose.
template <int Dim>
Gauge<Dim> gauge_of(const Network<Dim>& network, const Piece<Dim>& piece);

/// Puts fixed poses at their values.
template <int Dim>
void place_fixed_poses(const Network<Dim>& network, Piece<Dim>& piece);

}  // namespace mapjoin
