// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Several maps of the same things in one frame.

#include <apps/picture/plotted_map.hpp>
#include <mapjoin/join/consistency.hpp>
#include <optional>

namespace mapjoin::apps {

/// The rigid motion that best takes `map`, and the truth of a map, onto `first`, by the places of what both know; nothing where
/// that does not determine one.
template <int Dim>
std::optional<Pose<Dim>> alignment(const GlobalMap<Dim>& map, const GlobalMap<Dim>& first);
template <int Dim>
std::optional<Pose<Dim>> alignment(const Truth<Dim>& truth, const GlobalMap<Dim>& first);

/// The same map seen from another frame: moved by `frame`.
template <int Dim>
void move(const Pose<Dim>& frame, PlottedMap<Dim>& plotted);
template <int Dim>
void move(const Pose<Dim>& frame, Truth<Dim>& truth);

}  // namespace mapjoin::apps
