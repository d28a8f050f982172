// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The times of poses, for logs whose format has none.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Gives every pose the time that a file has for its id: lines `id time` (s), with a comma or blanks between, more columns being
/// passed over; `#` starts a comment, and a first line that begins with no number and no symbol is a header. Lines of other ids
/// are passed over. Bad input, with its place: a line that is anything else, an id with two times or that poses of several
/// sessions have; a pose without a time.
template <int Dim>
Expected<void> read_stamps(const std::filesystem::path& path, Log<Dim>& log);

/// Gives every pose the time that its id is (ns).
template <int Dim>
void take_ids_as_stamps(Log<Dim>& log);

}  // namespace mapjoin
