// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The front door for logs of every format.

#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>

namespace mapjoin {

/// The log in a file, which is known by its content, not by its name: g2o, iSAM, the text and MAT forms of Victoria Park and of
/// the corrected DLR data, or `map.circles`; each also as gzip. Bad input are a file that is missing, a directory, empty or
/// unreadable, and one of another format.
Expected<AnyLog> open_log(const std::filesystem::path& path, const ReadOptions& options = {});

}  // namespace mapjoin
