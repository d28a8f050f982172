// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Local maps that go into a store as they are built, so that a build that is killed loses little.

#include <mapjoin/io/store/store.hpp>
#include <mapjoin/localmap/build.hpp>
#include <string>

namespace mapjoin {

/// What maps depend on beside the log and its segments, for StoreWriter: a build goes on only where it is the same.
std::string build_settings(const MinimiseOptions& solver);

/// Builds what a store has still to get, in parallel, and returns how many iterations it took; whoever opened the store
/// finishes it. `parts` has the segments of the store, and all poses that a map keeps. kInterrupted where `stop` was requested.
template <int Dim>
Expected<std::int64_t> build_into(StoreWriter<Dim>& store, const Log<Dim>& log, const Split& parts, const BuildOptions& options,
                                  const std::stop_token& stop = {});

}  // namespace mapjoin
