// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Planar logs as lines with covariances: the text forms of Victoria Park's "clean data" and of the corrected DLR data, the
// original DLR `map.circles`, and the text format of GTSAM's Victoria Park example.

#include <mapjoin/io/formats/edge_text.hpp>

namespace mapjoin {

/// The text form of Victoria Park's data, lines
/// - `ODOM i j dx dy dφ Pxx Pxy Pxφ Pyy Pyφ Pφφ`: pose j in the frame of pose i;
/// - `OBS i feature x y Pxx Pxy Pyy` or `OBS i feature x y quality Pxx Pxy Pyy`: a feature in the frame of pose i.
/// Observations of feature -1 are left out and counted as unassociated. P are covariances, which must be positive definite.
extern const EdgeText<2> kOdomObs;

/// GTSAM's text, lines
/// - `ODOMETRY i j dx dy dφ Pxx Pxy Pxφ Pyy Pyφ Pφφ`: pose j in the frame of pose i, odometry or closure;
/// - `LANDMARK i feature x y Pxx Pxy Pyy`: a feature in the frame of pose i.
/// P are covariances, which must be positive definite. (GTSAM's own loader takes an observation apart into bearing and range.)
/// Written files have one numbering, as is usual: features are numbered from a power of ten if they would meet poses.
extern const EdgeText<2> kGtsamText;

/// True if a line of kOdomObs or of `map.circles` may begin with `tag`.
bool is_covariance_text_tag(std::string_view tag);

/// The log in `text`, which stands at the start of a file of kOdomObs or of `map.circles`, lines
/// - `STEP image dx dy dφ Pxx Pxy Pyy Pxφ Pyφ Pφφ` (mind the order): odometry from pose k-1 to pose k, counted from 0;
/// - `LANDMARK_C x y quality Pxx Pxy Pyy feature`: a feature in the frame of the pose to which the last step leads;
/// observations of feature -1 are left out and counted as unassociated.
Expected<AnyLog> read_covariance_text(TextScanner text, const ReadOptions& options);

}  // namespace mapjoin
