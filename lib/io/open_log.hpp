// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The front door for logs of every format.

#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>

namespace mapjoin {

/// The log in a file, which is known by its content, not by its name: g2o, TORO, iSAM, GTSAM's text, the text and MAT forms of
/// Victoria Park and of the corrected DLR data, `map.circles`, or a TUM or KITTI trajectory; each also as gzip. Or the log in a
/// folder of UTIAS MRCLAM data. Bad input are a file that is missing, another folder, a file that is empty or unreadable, and
/// one of another format.
Expected<AnyLog> open_log(const std::filesystem::path& path, const ReadOptions& options = {});

}  // namespace mapjoin
