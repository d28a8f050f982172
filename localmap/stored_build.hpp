// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Building local maps straight into a store, so that a build that is killed loses little.

#include <mapjoin/io/store/store.hpp>
#include <mapjoin/localmap/build.hpp>
#include <string>

namespace mapjoin {

/// The settings that maps depend on beside the log and its segments, as text for StoreWriter: a build goes on only with the
/// same.
std::string build_settings(const MinimiseOptions& solver);

/// Builds the maps that a store still lacks, in parallel, and returns the number of iterations; the caller finishes the store.
/// `parts` has the segments of the store, and all poses that a map keeps. kInterrupted on stop.
template <int Dim>
Expected<std::int64_t> build_into(StoreWriter<Dim>& store, const Log<Dim>& log, const Split& parts, const BuildOptions& options,
                                  const std::stop_token& stop = {});

}  // namespace mapjoin
