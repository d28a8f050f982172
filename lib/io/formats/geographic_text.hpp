// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A global map in latitude and longitude, for maps that stand in a GeographicFrame. In the plane places have no height.

#include <filesystem>
#include <mapjoin/gps/geographic_frame.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>

namespace mapjoin {

// Files appear whole or not at all: kCannotWrite.

/// A table of poses as that of write_csv(), with `latitude,longitude` (°) and, in space, `height` (m) for the pose.
template <int Dim>
Expected<void> write_geographic_csv(const GlobalMap<Dim>& map, const GeographicFrame& frame, const std::filesystem::path& path);

/// GeoJSON (RFC 7946): the trajectory of each session as a LineString, each feature as a Point.
template <int Dim>
Expected<void> write_geojson(const GlobalMap<Dim>& map, const GeographicFrame& frame, const std::filesystem::path& path);

}  // namespace mapjoin
