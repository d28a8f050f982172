// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Planar logs in the text format of GTSAM's Victoria Park example: `ODOMETRY LANDMARK` with covariances.

#include <filesystem>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Whether a line that begins with `tag` is of this format: its observations have the tag of iSAM's, its odometry is its own.
bool is_gtsam_odometry_tag(std::string_view tag);

/// The log in `text`, which stands at the begin of a file of lines
/// - `ODOMETRY i j dx dy dφ Pxx Pxy Pxφ Pyy Pyφ Pφφ`: pose j in the frame of pose i, odometry or closure;
/// - `LANDMARK i feature x y Pxx Pxy Pyy`: a feature in the frame of pose i.
/// P are covariances, which must be positive definite. (GTSAM's own loader takes an observation apart into bearing and range.)
Expected<AnyLog> read_gtsam_text(TextScanner text, const ReadOptions& options);

/// Edges and observations in one numbering, as such files have: features are numbered from a power of ten where they would meet
/// poses. kUsage where an information matrix is singular (see write_edge_text()).
Expected<void> write_gtsam_text(const Log<2>& log, const std::filesystem::path& path);

}  // namespace mapjoin
