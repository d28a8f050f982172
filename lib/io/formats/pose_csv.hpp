// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The table of a map's poses, as write_csv() writes it, read as a log that has nothing but the values of its poses.

#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// Whether a text begins with the header of such a table.
bool is_pose_csv(std::string_view bytes);

/// The poses of all lines under their ids, with their time stamps where there are any. The header says which columns there are:
/// `pose`, `x`, `y`, then `phi` in the plane or `z`, `qx`, `qy`, `qz`, `qw` in space; `session` and `stamp_ns` may be there,
/// and any other column is passed over. Bad input, with its place: a column or a number that is missing, a pose with two lines.
Expected<AnyLog> read_pose_csv(std::string_view bytes, const std::string& file, const ReadOptions& options);

}  // namespace mapjoin
