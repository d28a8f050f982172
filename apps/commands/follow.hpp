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
  double idle_seconds = 5.0;    ///< The log is complete when it has not grown for so long.
  std::filesystem::path steps;  ///< A line of JSON per added map; empty: none; "-": standard output.
};

/// --follow, --idle, --steps
void add_following(Subcommand& command, FollowOptions& options);
/// What of these contradicts the rest.
std::vector<std::string> check_following(const Subcommand& command, const Options& options, const FollowOptions& following);

struct FollowedLog {
  AnyLog log;                  ///< All that was read, with the weights of the file.
  std::optional<Error> fault;  ///< What was wrong behind it.
};

/// Follows the input until it has not grown for a while or a stop is requested, and says what each added map did. Fails
/// (see exit_code.hpp) with bad input where nothing of it can be used; kCannotWrite where the steps cannot be written.
FollowedLog follow(const Options& options, const FollowOptions& following, const std::stop_token& stop);

}  // namespace mapjoin::apps
