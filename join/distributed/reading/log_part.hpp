// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log that is spread over ranks: the names of its poses and features, which all of them know, and of its factors those that
// stand in the lines of one rank.

#include <mapjoin/distributed/reading/text_part.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/log.hpp>
#include <variant>

namespace mapjoin::distributed {

/// In this room poses and features are numbered by their names in ascending order, unless they are said to be those of one
/// rank.
template <int Dim>
struct LogPart {
  std::string source;
  Conventions conventions;
  SkipCounts skipped;
  PoseIds poses;
  FeatureIds features;
  FactorGraph<Dim> graph;  ///< Factors of this rank; fixed poses of all, as everything before.
};

using AnyLogPart = std::variant<LogPart<2>, LogPart<3>>;

/// Two things that a factor ties, by their numbers in some graph.
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

/// The same dimension on all ranks. Bad input as of a reader of the whole file, the same on all ranks, that of the first line
/// that is wrong.
Expected<AnyLogPart> read_log_part(const Communicator& comm, const std::filesystem::path& path, const ReadOptions& options);

/// Bad input where there are no poses; kUsage where they are too few for so many regions a rank.
Expected<void> check_worth_it(const Communicator& comm, const std::string& source, const PoseIds& poses, std::size_t regions);

/// As mapjoin::check_connected(), the same on all ranks. Of the factors of a rank, the first rank sees a spanning forest.
template <int Dim>
Expected<void> check_connected(const Communicator& comm, const LogPart<Dim>& part);

}  // namespace mapjoin::distributed
