// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How a map grows while its local maps are joined one after the other.

#include <apps/picture/plotted_map.hpp>
#include <functional>
#include <mapjoin/join/network.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin::apps {

/// The network joined map after map, as Schedule::kSequential does, each stop in the frame of `map`, the whole one: after every
/// map, or of many after so many that a page can hold all stops. What is not yet tied to the first pose is left out. The last
/// stop holds all maps, not yet solved for the last time.
template <int Dim>
std::vector<JoinStop<Dim>> join_stops(const Network<Dim>& network, const GlobalMap<Dim>& map,
                                      const std::function<void(std::size_t, std::size_t)>& progress,
                                      const std::stop_token& stop);

}  // namespace mapjoin::apps
