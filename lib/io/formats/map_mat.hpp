// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A global map as matrices in a MAT file, for MATLAB and Octave.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>

namespace mapjoin {

/// `poses`, one row each: session, id, x, y, phi, or x, y, z, qx, qy, qz, qw (m, rad); `features`: id, x, y(, z); where the map
/// has them, `stamps` (s) and, upper triangles row by row as in write_csv(), `pose_covariances`, `feature_covariances`. kUsage
/// where an id is no double, from 2⁵³ on; kCannotWrite, and then no file appears.
template <int Dim>
Expected<void> write_mat_map(const GlobalMap<Dim>& map, const std::filesystem::path& path);

}  // namespace mapjoin
