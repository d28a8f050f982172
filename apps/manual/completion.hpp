// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a shell needs to complete the command's words.

#include <apps/manual/description.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps::manual {

/// For bash-completion: the file `mapjoin`.
std::string bash_completion(const Command& mapjoin, const std::vector<Command>& all);
/// For zsh: the file `_mapjoin`.
std::string zsh_completion(const Command& mapjoin, const std::vector<Command>& all);

}  // namespace mapjoin::apps::manual
