// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log with its local maps, spread over ranks by time.

#include <functional>
#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/measure/counts.hpp>
#include <variant>

namespace mapjoin::distributed {

/// Figures of a log over all ranks.
struct LogFigures {
  Conventions conventions;
  Counts counts;
  bool is_resumed = false;   ///< True if some of the local maps were in stores before.
  bool was_damaged = false;  ///< True if an unfinished store was damaged, and is begun afresh.
};

template <int Dim>
struct MappedLog {
  LogPart<Dim> whole;  ///< The log; its factors are in the shares.
  LogShare<Dim> share;
  ShareMaps<Dim> maps;
  LogFigures log;
  RunFigures figures;  ///< Figures of the maps of all ranks.
};
using AnyMappedLog = std::variant<MappedLog<2>, MappedLog<3>>;

/// The mapped log with the figures of all ranks.
template <int Dim>
MappedLog<Dim> mapped_log(const Communicator& comm, LogPart<Dim> whole, LogShare<Dim> share, ShareMaps<Dim> maps);

/// Called on all ranks with the names of a log; ends the call, by the same exception on all, if these do not serve.
using NamesCheck = std::function<void(const PoseIds&, const FeatureIds&)>;

/// The reading and mapping of a log, the same on all ranks.
struct LogTask {
  std::filesystem::path log;
  ReadOptions read;
  Covariance covariance = Covariance::kOriginal;
  RunOptions run;                    ///< Options for building local maps.
  std::filesystem::path stores;      ///< Folder for the stores of the ranks, from which a killed call resumes; empty: none.
  NamesCheck check_names = nullptr;  ///< Called before maps are built; null: none.
};

/// Reads a log and builds its local maps. Errors are the same on all ranks: kBadInput as of mapjoin::run(), and those of
/// check_worth_it(), prepare_stores() and stored_maps().
Expected<AnyMappedLog> mapped_log(const Communicator& comm, const LogTask& task);

/// The log and its local maps from stores that all ranks can read: all portions of a log, or stores of one whole log, of which
/// the first that has a map counts. Each rank reads some of the factors and the maps of its share, which ends where segments
/// meet. Errors are the same on all ranks: kBadInput as of open_several_maps(); kUsage if the stores are of several logs, have
/// local maps alone, or have too few segments for the ranks.
Expected<AnyMappedLog> stored_log(const Communicator& comm, const std::vector<std::filesystem::path>& paths);

}  // namespace mapjoin::distributed
