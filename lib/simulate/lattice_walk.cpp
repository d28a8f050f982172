// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cassert>
#include <mapjoin/simulate/lattice_walk.hpp>
#include <numbers>

namespace mapjoin {

template <int Dim>
void LatticeWalk<Dim>::advance() {
  position_ += rotation_.col(0);
  if (at_corner()) turn();
}

template <int Dim>
bool LatticeWalk<Dim>::at_corner() const {
  return (position_.array() - position_.array() / steps_per_block_ * steps_per_block_ == 0).all();
}

template <int Dim>
bool LatticeWalk<Dim>::leads_out(const LatticePoint<Dim>& direction) const {
  const LatticePoint<Dim> next = position_ / steps_per_block_ + direction;
  return (next.array() < box_.low.array()).any() || (next.array() > box_.high.array()).any();
}

template <int Dim>
void LatticeWalk<Dim>::turn() {
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

Rotation<2> to_rotation(const LatticeRotation<2>& rotation) {
  const auto cosine = static_cast<double>(rotation(0, 0));
  const auto sine = static_cast<double>(rotation(1, 0));
  return Rotation<2>(cosine < 0.0 ? std::numbers::pi : 0.5 * std::numbers::pi * sine);
}

Rotation<3> to_rotation(const LatticeRotation<3>& rotation) {
  return Rotation<3>(Matrix<3>(rotation.cast<double>()));
}

template class LatticeWalk<2>;
template class LatticeWalk<3>;

}  // namespace mapjoin
