// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log with its local maps, spread over ranks by time.

#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/measure/counts.hpp>
#include <variant>

namespace mapjoin::distributed {

/// What there is of a log, on all ranks together.
struct LogFigures {
  Conventions conventions;
  Counts counts;
  bool is_resumed = false;   ///< Some of the local maps were in stores before.
  bool was_damaged = false;  ///< A store that was not finished was damaged, and is begun afresh.
};

template <int Dim>
struct MappedLog {
  LogPart<Dim> whole;  ///< Whose factors are in the shares.
  LogShare<Dim> share;
  ShareMaps<Dim> maps;
  LogFigures log;
  RunFigures figures;  ///< Of the maps of all ranks.
};
using AnyMappedLog = std::variant<MappedLog<2>, MappedLog<3>>;

/// With the figures of what all ranks hold.
template <int Dim>
MappedLog<Dim> mapped_log(const Communicator& comm, LogPart<Dim> whole, LogShare<Dim> share, ShareMaps<Dim> maps);

/// What is made of a log, by all ranks alike.
struct LogTask {
  std::filesystem::path log;
  ReadOptions read;
  Covariance covariance = Covariance::kOriginal;
  RunOptions run;                ///< How local maps are built.
  std::filesystem::path stores;  ///< A folder for the stores of the ranks, from which a call that was killed goes on; or empty.
};

/// Bad input, the same on all ranks, as of mapjoin::run().
Expected<AnyMappedLog> mapped_log(const Communicator& comm, const LogTask& task);

/// Out of stores that all ranks can read: the portions of a log, all of them, or stores of one whole log, of which the first
/// that has a map counts. Each rank reads some of the factors, and the maps of its share, which ends where segments meet. Bad
/// input, the same on all ranks, as of open_several_maps(); kUsage where stores are of several logs, or have too few segments
/// for the ranks.
Expected<AnyMappedLog> stored_log(const Communicator& comm, const std::vector<std::filesystem::path>& paths);

}  // namespace mapjoin::distributed
