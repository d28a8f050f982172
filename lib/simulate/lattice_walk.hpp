// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A random walk along the streets of a lattice, in whole steps and quarter turns, so that the true path is exact.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/simulate/random_stream.hpp>

namespace mapjoin {

/// A place on the lattice, in steps.
template <int Dim>
using LatticePoint = Eigen::Matrix<std::int64_t, Dim, 1>;
/// A rotation by quarter turns, columns forward, left (and up).
template <int Dim>
using LatticeRotation = Eigen::Matrix<std::int64_t, Dim, Dim>;

/// The box of corners that the walk stays in, in blocks; it starts at corner 0, which is inside.
template <int Dim>
struct LatticeBox {
  LatticePoint<Dim> low;
  LatticePoint<Dim> high;
};

/// Starts at the origin along the first axis. After each step onto a corner it goes straight on with probability 1/2 and turns
/// on the spot otherwise: left or right, in space also up or down, alike. Ways out of the box are left out of the choice.
template <int Dim>
class LatticeWalk {
 public:
  /// The box must be at least one block wide along the first two axes, on the far side of the first one's origin.
  LatticeWalk(std::int64_t steps_per_block, const LatticeBox<Dim>& box, const RandomStream& random)
      : steps_per_block_(steps_per_block), box_(box), random_(random) {}

  void advance();

  const LatticePoint<Dim>& position() const { return position_; }
  const LatticeRotation<Dim>& rotation() const { return rotation_; }

 private:
  bool at_corner() const;
  bool leads_out(const LatticePoint<Dim>& direction) const;
  void turn();

  std::int64_t steps_per_block_;
  LatticeBox<Dim> box_;
  RandomStream random_;
  LatticePoint<Dim> position_ = LatticePoint<Dim>::Zero();
  LatticeRotation<Dim> rotation_ = LatticeRotation<Dim>::Identity();
};

/// The same rotation for geometry; headings are 0, ±π/2 or π.
Rotation<2> to_rotation(const LatticeRotation<2>& rotation);
Rotation<3> to_rotation(const LatticeRotation<3>& rotation);

}  // namespace mapjoin
