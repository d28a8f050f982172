// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The local maps of one rank in a store, which is where a call goes on that was killed.

#include <filesystem>
#include <mapjoin/distributed/share_maps.hpp>

namespace mapjoin::distributed {

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
