// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The formats of logs: their names, how they are recognised, read and written, and what they have no place for.

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

/// The formats of logs, in the order in which they are recognised.
enum class LogFormat : std::uint8_t {
  kG2o,
  kToro,
  kGtsam,  ///< Plane only, as kOdomObs and kMat.
  kIsam,
  kOdomObs,  ///< The text form of Victoria Park's data and, for reading, map.circles.
  kMat,      ///< Victoria Park's MAT file.
  kTum,      ///< Values of poses only, as kKitti and kCsv.
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

/// The extension of a format's files: ".g2o", ".txt", …
std::string_view file_extension(LogFormat format);

/// The log in a file's bytes, in the format that the options name or, without, that its content shows. Bad input, in a sentence
/// that begins with `file`; kUsage if the options turn information matrices and the file is not in g2o, or read_g2o() refuses.
Expected<AnyLog> read_log(std::string_view bytes, const std::string& file, const ReadOptions& options);

/// True if a log needs the values of all poses to be written: for TORO's format, trajectories and the table of poses.
bool needs_values(LogFormat format);

/// True if these are poses 0, 1, 2, … of session 0.
bool are_counted(const std::vector<PoseId>& poses);

/// The parts of the log that the format has no place for or changes, a sentence without its end for each; empty if the written
/// file reads back as the same log, bit by bit (but for its source and conventions).
template <int Dim>
std::vector<std::string> losses(const Log<Dim>& log, LogFormat format);

/// Writes the parts of a log that the format has a place for. kUsage if the log is in space and the format planar, if it lacks
/// values that the format needs, if it has neither edges nor observations and the format nothing else, or if the writer refuses
/// it; kCannotWrite.
template <int Dim>
Expected<void> write_log(const Log<Dim>& log, LogFormat format, const std::filesystem::path& path);

}  // namespace mapjoin
