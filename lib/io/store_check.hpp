// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whether what a store holds keeps the promises of the model: its file may come from a stranger.

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <vector>

namespace mapjoin::store {

/// Every index names something, names and what is fixed ascend, sessions hold every pose once and in order, no closure leads
/// from a pose to itself, arrays that go with poses or features are as long, numbers are finite, rotations are rotations, and
/// information matrices are symmetric and positive semidefinite.
template <int Dim>
Expected<void> check_log(const Log<Dim>& log, const std::string& file);

/// Stretches are in order and made of poses of the log.
template <int Dim>
Expected<void> check_stretches(const std::vector<Stretch>& stretches, const Log<Dim>& log, const std::string& file);

/// A local map of `stretch` over poses and features of the log, with an information matrix as above.
template <int Dim>
Expected<void> check_map(const LocalMap<Dim>& map, const Stretch& stretch, const Log<Dim>& log, const std::string& file);

}  // namespace mapjoin::store
