// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the targets of local maps share.

#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <string_view>

namespace mapjoin::fuzz {

/// The set of one map that stands in a file of this name.
void check_local_map(const char* name, std::string_view bytes, LocalMapFormat written);

/// Maps that can be written read back; in the plane, as text, with the same bits.
void check_round_trip(const AnySubmapSet& set, LocalMapFormat format);

}  // namespace mapjoin::fuzz
