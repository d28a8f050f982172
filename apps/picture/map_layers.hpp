// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a picture of maps is drawn of.

#include <apps/picture/picture.hpp>
#include <apps/picture/plotted_map.hpp>
#include <mapjoin/join/consistency.hpp>
#include <vector>

namespace mapjoin::apps {

/// A single map with all that is known of it: local maps in colours of their own, where they end, closures, features, ellipses
/// of three standard deviations. Several maps each in one colour. `truth`, over the first map's poses and features, may be
/// null. At least one map, all in one frame.
template <int Dim>
std::vector<Layer> map_layers(const std::vector<PlottedMap<Dim>>& maps, const Truth<Dim>* truth);

}  // namespace mapjoin::apps
