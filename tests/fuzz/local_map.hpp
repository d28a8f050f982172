// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Checks that the targets of local maps share.

#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <string_view>

namespace mapjoin::fuzz {

/// Checks the set of the one map in a file of this name, and that it reads back when written.
void check_local_map(const char* name, std::string_view bytes, LocalMapFormat written);

/// Checks that maps that the format can hold read back when written: with the same bits as text in the plane.
void check_round_trip(const AnySubmapSet& set, LocalMapFormat format);

}  // namespace mapjoin::fuzz
