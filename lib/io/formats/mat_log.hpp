// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// MAT files: the paper's two logs, Victoria Park's "clean data" and the corrected DLR data, and a global map for MATLAB and
// Octave.

#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// The planar log in the MAT file with the content `bytes`, which holds one of the variables
/// - `VicPark_clean_data`, n × 12, with rows `1 i j dx dy dφ` and the upper triangle of a 3 × 3 covariance, row by row, or
/// `0 i feature x y` and that of a 2 × 2 one;
/// - `corrected_data_circles`, n × 10, with rows `-100 dx dy dφ Pxx Pxy Pyy Pxφ Pyφ Pφφ`, each of which begins the next pose,
/// or `x y quality Pxx Pxy Pyy feature` of the features seen there; those of feature -1 are left out and counted as
/// unassociated.
/// Errors name `file`, variable and row.
Expected<AnyLog> read_mat_log(std::string_view bytes, const std::string& file, const ReadOptions& options = {});

/// Writes the variable `VicPark_clean_data` with the log's edges, then its observations. kUsage if an information matrix is
/// singular, or an id is 2^53 or more; kTooLarge if the variable takes 2 GiB or more; kCannotWrite.
Expected<void> write_mat_log(const Log<2>& log, const std::filesystem::path& path);

/// kUsage if a double does not hold one of these ids, which is 2⁵³ or more: write_mat_map() refuses them.
Expected<void> check_mat_ids(const PoseIds& poses, const FeatureIds& features);

/// Writes a global map: `poses`, one row each: session, id, x, y, phi, or x, y, z, qx, qy, qz, qw (m, rad); `features`: id, x,
/// y(, z); if the map has them, `stamps` (s) and, upper triangles row by row as in write_csv(), `pose_covariances`,
/// `feature_covariances`. kUsage if an id is 2⁵³ or more, which a double does not hold; kTooLarge if a variable takes 2 GiB or
/// more; kCannotWrite, and then no file appears. Throws std::invalid_argument if the map is not whole (see demand_whole).
template <int Dim>
Expected<void> write_mat_map(const GlobalMap<Dim>& map, const std::filesystem::path& path);

}  // namespace mapjoin
