// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tables of poses: time stamps for logs whose format has none, and a map's poses as write_csv() writes them, read as a log of
// nothing but the values of its poses.

#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// Gives every pose the time that a file has for its id: lines `id time` (s), separated by a comma or blanks; `#` starts a
/// comment, and a first line that begins with no number and no symbol is a header. Further columns and lines of other ids are
/// passed over. Bad input, with its place: any other line, an id with two times or that poses of several sessions have; a pose
/// without a time.
template <int Dim>
Expected<void> read_stamps(const std::filesystem::path& path, Log<Dim>& log);

/// Gives every pose its id as its time (ns); bad input if an id is 2^63 or more, or a GTSAM symbol.
template <int Dim>
Expected<void> take_ids_as_stamps(Log<Dim>& log);

/// True if a text begins with the header of the table of a map's poses.
bool is_pose_csv(std::string_view bytes);

/// The poses of a table that write_csv() could have written, in its order and under their ids, with their time stamps if there
/// are any. The header names the columns: `pose`, `x`, `y`, then `phi` in the plane or `z`, `qx`, `qy`, `qz`, `qw` in space;
/// `session` and `stamp_ns` are optional, and any other column is passed over. Bad input, with its place: a missing column or
/// number, a second line of a pose.
template <int Dim>
Expected<GlobalMap<Dim>> read_pose_table(std::string_view bytes, const std::string& file);

/// The poses of read_pose_table() as a log, in the order of the table and the dimension of its header.
Expected<AnyLog> read_pose_csv(std::string_view bytes, const std::string& file, const ReadOptions& options);

}  // namespace mapjoin
