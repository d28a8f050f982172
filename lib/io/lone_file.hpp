// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A file that one process at a time writes, and whose left-over a later one takes for its own.

#include <filesystem>
#include <mapjoin/model/error.hpp>

namespace mapjoin {

/// A new descriptor for writing to `path`, which is made where it is not there, locked until the descriptor is closed, and
/// emptied: it is what a process left that was killed. To be renamed or removed before it is closed. kCannotWrite, about
/// `output`, where that cannot be, or where another process has the file.
Expected<int> open_alone(const std::filesystem::path& path, const std::filesystem::path& output);

}  // namespace mapjoin
