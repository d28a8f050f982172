// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log that is spread over ranks: all of them know the names of its poses and features; each has the factors that stand in its
// lines.

#include <mapjoin/distributed/reading/text_part.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/log.hpp>
#include <variant>

namespace mapjoin::distributed {

/// One rank's part of a log. Throughout join/distributed, poses and features are numbered by all names in ascending order,
/// unless they are said to be those of one rank.
template <int Dim>
struct LogPart {
  std::string source;
  Conventions conventions;
  SkipCounts skipped;
  PoseIds poses;
  FeatureIds features;
  FactorGraph<Dim> graph;  ///< Factors of this rank; its fixed poses, as all members before, are those of all ranks.
};

using AnyLogPart = std::variant<LogPart<2>, LogPart<3>>;

/// Two vertices that a factor connects, by their numbers in some graph.
struct Link {
  std::int32_t a = 0;
  std::int32_t b = 0;
  auto operator<=>(const Link&) const = default;
};
template <typename F>
void fields(Link& link, const F& f) {
  f(link.a);
  f(link.b);
}

/// Reads the part of this rank, of the same dimension on all ranks. kBadInput as of a reader of the whole file, the same on all
/// ranks: that of the first wrong line.
Expected<AnyLogPart> read_log_part(const Communicator& comm, const std::filesystem::path& path, const ReadOptions& options);

/// Checks the number of poses. kBadInput if there are none; kUsage if they are too few for so many regions per rank.
Expected<void> check_worth_it(const Communicator& comm, const std::string& source, const PoseIds& poses, std::size_t regions);

/// Checks that the log is connected, as mapjoin::check_connected(), with the same result on all ranks. The first rank sees a
/// spanning forest of the factors of each.
template <int Dim>
Expected<void> check_connected(const Communicator& comm, const LogPart<Dim>& part);

}  // namespace mapjoin::distributed
