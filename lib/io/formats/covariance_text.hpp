// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Planar logs as lines with covariances: the text forms of Victoria Park's "clean data" and of the corrected DLR data, the
// original DLR `map.circles`, and the text format of GTSAM's Victoria Park example.

#include <filesystem>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Whether a line of one of the formats below may begin with `tag`.
bool is_covariance_text_tag(std::string_view tag);

/// The log in `text`, which stands at the begin of a file of lines
/// - `ODOM i j dx dy dφ Pxx Pxy Pxφ Pyy Pyφ Pφφ`: pose j in the frame of pose i;
/// - `OBS i feature x y Pxx Pxy Pyy` or `OBS i feature x y quality Pxx Pxy Pyy`: a feature in the frame of pose i,
///
/// or of lines
/// - `STEP image dx dy dφ Pxx Pxy Pyy Pxφ Pyφ Pφφ` (mind the order): leads from pose k-1 to pose k, counted from 0;
/// - `LANDMARK_C x y quality Pxx Pxy Pyy feature`: seen at the pose that the last step leads to.
///
/// Observations of feature -1 are left out and counted as unassociated. A covariance that is not positive definite is bad
/// input.
Expected<AnyLog> read_covariance_text(TextScanner text, const ReadOptions& options);

/// Edges and observations. kUsage where an information matrix is singular (see write_edge_text()).
Expected<void> write_odom_obs(const Log<2>& log, const std::filesystem::path& path);

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
