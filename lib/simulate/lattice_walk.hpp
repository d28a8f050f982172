// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A random walk along the streets of a lattice, in whole steps and quarter turns, so that the true path is exact.

#include <Eigen/Core>
#include <array>
#include <cassert>
#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <numbers>

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

/// A walk that starts at the origin along the first axis. After each step onto a corner it goes straight on with probability
/// 1/2 and otherwise turns on the spot: left or right, in space also up or down, with equal probability. Ways out of the box
/// are left out of the choice.
template <int Dim>
class LatticeWalk {
 public:
  /// The box must be at least one block wide along the first two axes, along the first one on the positive side of the origin.
  LatticeWalk(std::int64_t steps_per_block, const LatticeBox<Dim>& box, const RandomStream& random)
      : steps_per_block_(steps_per_block), box_(box), random_(random) {}

  void advance() {
    position_ += rotation_.col(0);
    if (at_corner()) turn();
  }

  const LatticePoint<Dim>& position() const { return position_; }
  const LatticeRotation<Dim>& rotation() const { return rotation_; }

 private:
  bool at_corner() const { return (position_.array() - position_.array() / steps_per_block_ * steps_per_block_ == 0).all(); }

  bool leads_out(const LatticePoint<Dim>& direction) const {
    const LatticePoint<Dim> next = position_ / steps_per_block_ + direction;
    return (next.array() < box_.low.array()).any() || (next.array() > box_.high.array()).any();
  }

  void turn() {
    // Straight on as often as all turns together.
    constexpr std::size_t kTurns = 2 * std::size_t{Dim - 1};
    std::array<LatticeRotation<Dim>, 2 * kTurns> choices;
    std::size_t count = 0;
    const auto offer = [&](const LatticeRotation<Dim>& rotation) {
      if (!leads_out(rotation.col(0))) choices[count++] = rotation;
    };
    for (std::size_t i = 0; i < kTurns; ++i) offer(rotation_);
    for (int axis = 1; axis < Dim; ++axis) {
      for (const int sign : {1, -1}) {
        LatticeRotation<Dim> turned = rotation_;
        turned.col(0) = sign * rotation_.col(axis);
        turned.col(axis) = -sign * rotation_.col(0);
        offer(turned);
      }
    }
    assert(count > 0);  // There is a way on from every corner of a box as wide as promised.
    rotation_ = choices[random_.next() % count];
  }

  std::int64_t steps_per_block_;
  LatticeBox<Dim> box_;
  RandomStream random_;
  LatticePoint<Dim> position_ = LatticePoint<Dim>::Zero();
  LatticeRotation<Dim> rotation_ = LatticeRotation<Dim>::Identity();
};

/// The lattice rotation as a Rotation; headings are 0, ±π/2 or π.
inline Rotation<2> to_rotation(const LatticeRotation<2>& rotation) {
  const auto cosine = static_cast<double>(rotation(0, 0));
  const auto sine = static_cast<double>(rotation(1, 0));
  return Rotation<2>(cosine < 0.0 ? std::numbers::pi : 0.5 * std::numbers::pi * sine);
}

inline Rotation<3> to_rotation(const LatticeRotation<3>& rotation) {
  return Rotation<3>(Matrix<3>(rotation.cast<double>()));
}

}  // namespace mapjoin
