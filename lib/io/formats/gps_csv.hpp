// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The fixes of a satellite receiver as a table.

#include <filesystem>
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// The fixes of a table, one a line. The first line names the columns, in any order: `time` (s, as the time stamps of poses) or
/// `pose` (its id), `latitude`, `longitude` (°), `sd_east`, `sd_north` (m) and, for maps in space, `height`, `sd_up` (m);
/// `session` is optional, and any other column is passed over. Bad input, with its place: a missing column or number, a place
/// that is not on the earth, a standard deviation that is not positive or beyond reason; a table without fixes.
Expected<GpsFixes> read_gps_csv(std::string_view bytes, const std::string& file);
Expected<GpsFixes> read_gps_csv(const std::filesystem::path& path);

}  // namespace mapjoin
