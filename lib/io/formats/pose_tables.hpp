// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tables of poses: their times, for logs whose format has none, and a map's, as write_csv() writes it, read as a log that has
// nothing but the values of its poses.

#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// Gives every pose the time that a file has for its id: lines `id time` (s), with a comma or blanks between, more columns
/// being passed over; `#` starts a comment, and a first line that begins with no number and no symbol is a header. Lines of
/// other ids are passed over. Bad input, with its place: a line that is anything else, an id with two times or that poses of
/// several sessions have; a pose without a time.
template <int Dim>
Expected<void> read_stamps(const std::filesystem::path& path, Log<Dim>& log);

/// Gives every pose the time that its id is (ns). Bad input where an id is 2^63 or more.
template <int Dim>
Expected<void> take_ids_as_stamps(Log<Dim>& log);

/// Whether a text begins with the header of the table of a map's poses.
bool is_pose_csv(std::string_view bytes);

/// The poses of all lines of such a table under their ids, with their time stamps where there are any. The header says which
/// columns there are: `pose`, `x`, `y`, then `phi` in the plane or `z`, `qx`, `qy`, `qz`, `qw` in space; `session` and
/// `stamp_ns` may be there, and any other column is passed over. Bad input, with its place: a column or a number that is
/// missing, a pose with two lines.
Expected<AnyLog> read_pose_csv(std::string_view bytes, const std::string& file, const ReadOptions& options);

}  // namespace mapjoin
