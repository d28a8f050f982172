// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Trajectories, TUM's and KITTI's, as logs that have nothing but the values of their poses. They are written by map_text.hpp.

#include <cstdint>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace mapjoin {

/// A time in seconds as nanoseconds, exactly where it is written without an exponent; nothing of other words.
std::optional<std::int64_t> nanoseconds(std::string_view word);

/// Whether `line`, which stands before a line, has that many numbers and nothing else.
bool is_tum_line(TextScanner line);
bool is_kitti_line(TextScanner line);

/// The poses 0, 1, … of a file of lines `time x y z qx qy qz qw`, at whose begin `text` stands, with their values and, to the
/// nanosecond, their times; times 0, 1, 2, … without a point count the poses. In the plane where every z, qx and qy is zero,
/// else in space. Bad input, with its place: other lines, quaternions far from unit length.
Expected<AnyLog> read_tum_log(TextScanner text, const ReadOptions& options);

/// The same of lines of twelve numbers, the rows of (R | t). A pose is in the plane where its z is zero and R turns about z.
/// R is brought to the nearest rotation; one that is far from any is bad input. There are no times.
Expected<AnyLog> read_kitti_log(TextScanner text, const ReadOptions& options);

struct StampedPose {
  double time = 0.0;  ///< (s), or a count where the poses have no stamps.
  Pose<3> pose;
};

/// The lines `time x y z qx qy qz qw` in their order; `#` starts a comment. Bad input, with the place, where a line is anything
/// else, has another pose than one before at its time, or a quaternion that is zero; quaternions are brought to unit length.
Expected<std::vector<StampedPose>> read_tum(TextScanner text);

}  // namespace mapjoin
