// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Manual pages in troff (man(7)).

#include <apps/manual/description.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps::manual {

/// mapjoin-NAME(1) of one of the commands.
std::string man_page(const Command& command, const std::vector<Command>& all);
/// mapjoin(1), of all.
std::string man_page_of_all(const Command& mapjoin, const std::vector<Command>& all);

}  // namespace mapjoin::apps::manual
