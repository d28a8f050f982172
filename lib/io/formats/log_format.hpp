// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The formats of logs: how each is called, known, read and written, and what it has no place for.

#include <cstdint>
#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin {

/// In the order in which they are recognised.
enum class LogFormat : std::uint8_t {
  kG2o,
  kToro,
  kGtsam,  ///< In the plane only, as kOdomObs and kMat.
  kIsam,
  kOdomObs,  ///< The text form of Victoria Park's data and, for reading, map.circles.
  kMat,      ///< Victoria Park's MAT file.
  kTum,      ///< The values of poses only, as kKitti.
  kKitti,
  kCsv,  ///< The table of a map's poses.
};

constexpr auto enum_names(LogFormat) {
  return std::to_array<EnumName<LogFormat>>({{LogFormat::kG2o, "g2o"},
                                             {LogFormat::kToro, "toro"},
                                             {LogFormat::kGtsam, "gtsam"},
                                             {LogFormat::kIsam, "isam"},
                                             {LogFormat::kOdomObs, "odom-obs"},
                                             {LogFormat::kMat, "mat"},
                                             {LogFormat::kTum, "tum"},
                                             {LogFormat::kKitti, "kitti"},
                                             {LogFormat::kCsv, "csv"}});
}

/// Of its files: ".g2o", ".txt", …
std::string_view file_extension(LogFormat format);

/// The log in a file's bytes, whose format is known by its content. Bad input, in a sentence that begins with `file`.
Expected<AnyLog> read_log(std::string_view bytes, const std::string& file, const ReadOptions& options);

/// Whether the format has nothing without the values of all poses: TORO's and trajectories.
bool needs_values(LogFormat format);

/// Whether these are poses 0, 1, 2, … of session 0.
bool are_counted(const std::vector<PoseId>& poses);

/// What of the log the format has no place for, or takes down otherwise than it is, a sentence without its end for each; empty
/// where what is written reads back as the same log, bit by bit (but for its source and conventions).
template <int Dim>
std::vector<std::string> losses(const Log<Dim>& log, LogFormat format);

/// Writes what the format has a place for. kUsage where that cannot be: a log in space for a planar format, none of the values
/// that it needs, neither edge nor observation for one that has nothing else, and what its writer refuses; kCannotWrite.
template <int Dim>
Expected<void> write_log(const Log<Dim>& log, LogFormat format, const std::filesystem::path& path);

}  // namespace mapjoin
