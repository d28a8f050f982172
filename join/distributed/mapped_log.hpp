// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log with its local maps, spread over ranks by time.

#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/io/read_options.hpp>
#include <variant>

namespace mapjoin::distributed {

/// What there is of a log, on all ranks together.
struct LogFigures {
  Conventions conventions;
  std::size_t poses = 0;
  std::size_t features = 0;
  std::int64_t odometry = 0;
  std::int64_t closures = 0;
  std::int64_t observations = 0;
  std::int64_t priors = 0;
  std::size_t fixed_poses = 0;
  SkipCounts skipped{};
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

}  // namespace mapjoin::distributed
