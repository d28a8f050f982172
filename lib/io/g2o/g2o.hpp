// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// g2o files in the plane and in space: `VERTEX_SE2 VERTEX_XY EDGE_SE2 EDGE_SE2_XY`, `VERTEX_SE3:QUAT VERTEX_TRACKXYZ
// EDGE_SE3:QUAT EDGE_SE3_TRACKXYZ PARAMS_SE3OFFSET`, priors, and `FIX`.

#include <filesystem>
#include <mapjoin/io/formats/edge_text.hpp>
#include <mapjoin/model/global_map.hpp>

namespace mapjoin {

/// Whether a line of a g2o file may begin with `tag`.
bool is_g2o_tag(std::string_view tag);

/// The log in `text`, which stands at the begin of a file. Poses and features are named apart: pose 7 and feature 7 may both
/// be. A file without vertices names them by its edges; in one with vertices, an edge to an undeclared id is bad input, unless
/// `options` say what becomes of it. Sensor offsets are applied: an observation, or a prior, is that of its pose. FIX holds
/// poses at their initial values. Parameters that nobody names are passed over, and so are data of sensors, which are counted.
/// Information matrices, those of priors too, are turned as `options` say. Of a text that is not whole, what other lines say of
/// an id is not missed, and FIX is passed over.
Expected<AnyLog> read_g2o(TextScanner text, const ReadOptions& options, Extent extent = {});

/// Writes the log in the conventions used inside, numbers with as many digits as bring back the same bits: what was read from a
/// file this function wrote is written as the same bytes. Vertices are written where every pose and feature has an initial
/// value. The file has one numbering: features are numbered from a power of ten where they would meet poses, and so are the
/// poses of further sessions. g2o holds no stamps. kUsage where a pose is fixed away from the origin without vertices;
/// kCannotWrite.
template <int Dim>
Expected<void> write_g2o(const Log<Dim>& log, const std::filesystem::path& path);

/// Writes the map's poses and features as vertices, its gauge as FIX and, where `log` is given, its edges and priors. `log` is
/// the one the map was made of. std::invalid_argument where it is over other poses or features, or the map is not whole (see
/// demand_whole).
template <int Dim>
Expected<void> write_g2o(const GlobalMap<Dim>& map, const Log<Dim>* log, const std::filesystem::path& path);

}  // namespace mapjoin
