// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The start of mapjoin_reference: `odometry`, `tree`, `values`, `tum:FILE` or `g2o:FILE`.

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <mapjoin/model/values.hpp>
#include <string>

namespace mapjoin::bench {

/// The start of this name for a log. `tum:FILE` gives a pose for every pose of the log, in its order; features are then at
/// their first observations. `g2o:FILE` gives the vertices of a g2o file, as many and in the same order.
template <int Dim>
Expected<Values<Dim>> start_of(const Log<Dim>& log, const std::string& name);

/// The start of this name for local maps: both `odometry` and `tree` are the maps composed end to end; there are no `values`.
template <int Dim>
Expected<Values<Dim>> start_of(const SubmapSet<Dim>& set, const std::string& name);

}  // namespace mapjoin::bench
