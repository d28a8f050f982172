// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// `mapjoin run --follow`: joins a log map by map while it is written.

#include <apps/commands/options.hpp>
#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin::apps {

struct FollowOptions {
  bool wanted = false;
  double idle_seconds = 5.0;    ///< Time without growth after which the log is complete (s).
  std::filesystem::path steps;  ///< File for a line of JSON per added map; empty: none; by is_stdout() standard output.
};

/// --follow, --idle, --steps
void add_following(Subcommand& command, FollowOptions& options);
/// Violations, in words, between these options and the others.
std::vector<std::string> check_following(const Subcommand& command, const Options& options, const FollowOptions& following);

struct FollowedLog {
  AnyLog log;                  ///< The log as read, with the weights of the file.
  std::optional<Error> fault;  ///< The error in the file behind it, if any.
};

/// Follows the input until it has not grown for a while or a stop is requested, and reports each added map. Fails (see
/// exit_code.hpp): bad input if nothing of it can be used; kCannotWrite if the steps cannot be written.
FollowedLog follow(const Options& options, const FollowOptions& following, const std::stop_token& stop);

}  // namespace mapjoin::apps
