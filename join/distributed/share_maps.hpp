// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The local maps of one rank, built at once or by way of a store, from which a killed call resumes.

#include <filesystem>
#include <mapjoin/distributed/reading/log_share.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/split.hpp>
#include <optional>
#include <vector>

namespace mapjoin::distributed {

/// The local maps of a share, by the indices of its log.
template <int Dim>
struct ShareMaps {
  Split split;  ///< Segments that did not determine a map are raw.
  std::vector<LocalMap<Dim>> maps;
  std::int64_t iterations = 0;  ///< Iterations for the maps that were built now.
  bool is_resumed = false;      ///< True if some maps were in a store before.
  bool was_damaged = false;     ///< True if an unfinished store was damaged.
};

template <int Dim>
Expected<ShareMaps<Dim>> built_maps(const LogShare<Dim>& share, const RunOptions& options);

/// Takes stored maps: one for each segment of `into` that is a map, in their order, by the indices of all names. A segment
/// whose map is nullopt did not determine one and becomes raw. kBadInput if the maps are not of this share.
template <int Dim>
Expected<void> take_maps(const LogShare<Dim>& share, std::vector<std::optional<LocalMap<Dim>>> maps, ShareMaps<Dim>& into);

/// The path of the store of a rank (from 0) of so many: `2-of-4.maps`.
std::filesystem::path store_of(int rank, int ranks, const std::filesystem::path& folder);

/// Makes sure that the folder for the stores of all ranks exists. Errors are the same on all ranks: kCannotWrite if it cannot
/// be made; kUsage if it has stores of another number of ranks.
Expected<void> prepare_stores(const Communicator& comm, const std::filesystem::path& folder);

/// The maps of built_maps(), by way of this rank's portion of the log and its maps in a store (docs/store.md). Maps of the same
/// log, segments and options that are in the store are not built again; the store is complete on return. Errors are the same on
/// all ranks: kCannotWrite; kUsage if poses were not driven in the order of their ids.
template <int Dim>
Expected<ShareMaps<Dim>> stored_maps(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                     const RunOptions& options, const std::filesystem::path& folder);

}  // namespace mapjoin::distributed
