// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Trajectories in TUM's and KITTI's formats, read as logs of nothing but the values of their poses; map_text.hpp writes them.

#include <cstdint>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace mapjoin {

/// A time in seconds as nanoseconds, rounded to the nearest, exactly if it is written without an exponent; nullopt for other
/// words.
std::optional<std::int64_t> nanoseconds(std::string_view word);

/// Reads the next word as a time in seconds, and gives it in nanoseconds.
std::int64_t read_time(TextScanner& text);

/// A time in nanoseconds as seconds.
inline double in_seconds(std::int64_t stamp_ns) {
  return 1e-9 * static_cast<double>(stamp_ns);
}

/// True if the next line of `line` has eight (TUM) or twelve (KITTI) numbers and nothing else.
bool is_tum_line(TextScanner line);
bool is_kitti_line(TextScanner line);

/// True if the lines of a TUM trajectory begin with 0, 1, 2, … without a point, as write_tum() counts poses without times.
bool counts_poses(TextScanner text);

/// The poses 0, 1, … of a file of lines `time x y z qx qy qz qw`, at whose start `text` stands, with their values and, to the
/// nanosecond, their times, unless it counts_poses(). In the plane if every z, qx and qy is zero, otherwise in space. Bad
/// input, with its place: other lines, quaternions far from unit length.
Expected<AnyLog> read_tum_log(TextScanner text, const ReadOptions& options);

/// The poses 0, 1, … of a file of lines of twelve numbers, the rows of (R | t), at whose start `text` stands, without times. In
/// the plane if every z is zero and every R turns about z, otherwise in space. R is brought to the nearest rotation; one that
/// is far from any is bad input.
Expected<AnyLog> read_kitti_log(TextScanner text, const ReadOptions& options);

struct StampedPose {
  double time = 0.0;  ///< (s), or a count if the poses have no stamps.
  Pose<3> pose;
};

/// The poses of lines `time x y z qx qy qz qw`, in their order; `#` starts a comment, and quaternions are brought to unit
/// length. Bad input, with its place: any other line, a quaternion that is zero, or another pose than a line before has at the
/// same time.
Expected<std::vector<StampedPose>> read_tum(TextScanner text);

}  // namespace mapjoin
