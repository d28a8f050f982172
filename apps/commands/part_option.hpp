// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// `--part K/N`: one of several parts of a piece of work, each done on its own.

#include <apps/commands/subcommand.hpp>
#include <functional>
#include <string>

namespace mapjoin::apps {

/// Calls take(K, N), 1 ≤ K ≤ N, where the option is given.
void add_part(Subcommand& command, const std::string& help, const std::function<void(std::size_t, std::size_t)>& take);

}  // namespace mapjoin::apps
