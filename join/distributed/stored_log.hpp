// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log and its local maps out of stores that all ranks can read.

#include <mapjoin/distributed/mapped_log.hpp>

namespace mapjoin::distributed {

/// The portions of a log, all of them, or stores of one whole log, of which the first that has a map counts. Each rank reads
/// some of the factors, and the maps of its share, which ends where segments meet. Bad input, the same on all ranks, as of
/// open_several_maps(); kUsage where stores are of several logs, or have too few segments for the ranks.
Expected<AnyMappedLog> stored_log(const Communicator& comm, const std::vector<std::filesystem::path>& paths);

}  // namespace mapjoin::distributed
