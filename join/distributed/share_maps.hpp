// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The local maps of one rank, built at once or by way of a store, which is where a call goes on that was killed.

#include <filesystem>
#include <mapjoin/distributed/reading/log_share.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/split.hpp>
#include <optional>
#include <vector>

namespace mapjoin::distributed {

/// By the indices of the share's log.
template <int Dim>
struct ShareMaps {
  Split split;  ///< What did not determine a map is raw.
  std::vector<LocalMap<Dim>> maps;
  std::int64_t iterations = 0;  ///< Of those that were built now.
  bool is_resumed = false;      ///< Some were in a store before.
  bool was_damaged = false;     ///< A store that was not finished was damaged.
};

template <int Dim>
Expected<ShareMaps<Dim>> built_maps(const LogShare<Dim>& share, const RunOptions& options);

/// Takes the maps of those of its segments that are maps, in their order, by the indices of all names; what is nothing did not
/// determine a map. Bad input where they are not of this share.
template <int Dim>
Expected<void> take_maps(const LogShare<Dim>& share, std::vector<std::optional<LocalMap<Dim>>> maps, ShareMaps<Dim>& into);

/// The store of a rank, from 0, of so many: `2-of-4.maps`.
std::filesystem::path store_of(int rank, int ranks, const std::filesystem::path& folder);

/// Makes sure of the folder for the stores of all ranks: kCannotWrite where it cannot be made, kUsage where it has those of
/// another number of ranks.
Expected<void> prepare_stores(const Communicator& comm, const std::filesystem::path& folder);

/// As built_maps(), by way of this rank's portion of the log and its maps in a store (docs/store.md): maps that are there, of
/// the same log, segments and options, are not built again, and the store is complete when it returns. The same on all ranks:
/// kCannotWrite, and kUsage where poses were driven in another order than that of their ids.
template <int Dim>
Expected<ShareMaps<Dim>> stored_maps(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                     const RunOptions& options, const std::filesystem::path& folder);

}  // namespace mapjoin::distributed
