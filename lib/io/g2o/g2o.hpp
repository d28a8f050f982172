// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// g2o files in the plane and in space: `VERTEX_SE2 VERTEX_XY EDGE_SE2 EDGE_SE2_XY`, `VERTEX_SE3:QUAT VERTEX_TRACKXYZ
// EDGE_SE3:QUAT EDGE_SE3_TRACKXYZ PARAMS_SE3OFFSET`, priors, and `FIX`.

#include <filesystem>
#include <mapjoin/io/formats/edge_text.hpp>
#include <mapjoin/io/formats/undeclared.hpp>
#include <mapjoin/model/global_map.hpp>
#include <optional>

namespace mapjoin {

/// True if a line of a g2o file may begin with `tag`.
bool is_g2o_tag(std::string_view tag);

/// The log in `text`, which stands at the start of a file. Poses and features are named apart: a pose 7 and a feature 7 are
/// different. A file without vertices names them by its edges; in one with vertices, an edge to an undeclared id is bad input
/// unless `options` say otherwise. Sensor offsets are applied: observations and priors become those of the pose. FIX holds
/// poses at their initial values. Parameters that nobody names are passed over, and so are data of sensors, which are counted.
/// Information matrices, including those of priors, are turned as `options` say; kUsage if the text is of write_g2o(), whose
/// matrices are not to be turned again. In a text that is not whole, ids need no
/// vertices, and FIX is passed over.
Expected<AnyLog> read_g2o(TextScanner text, const ReadOptions& options, Extent extent = {});

/// The first pose or feature that a line of a g2o file in this dimension names and no vertex declares; nullopt if there is
/// none.
template <int Dim>
std::optional<UndeclaredName> first_undeclared_in_g2o(TextScanner text, const Declared& declared);

/// Writes the log in the conventions used inside, with enough digits to bring back the same bits: a log read from such a file
/// is written as the same bytes. Vertices are written if every pose and feature has an initial value. The file has one
/// numbering: features are numbered from a power of ten if they would meet poses, and so are the poses of further sessions. g2o
/// holds no stamps. kUsage if a pose is fixed away from the origin and there are no vertices; kCannotWrite.
template <int Dim>
Expected<void> write_g2o(const Log<Dim>& log, const std::filesystem::path& path);

/// Writes the map's poses and features as vertices, its gauge as FIX and, if `log` is given, the edges, observations and priors
/// of that log, the one the map was made of. Throws std::invalid_argument if the log is over other poses or features, or the
/// map is not whole (see demand_whole).
template <int Dim>
Expected<void> write_g2o(const GlobalMap<Dim>& map, const Log<Dim>* log, const std::filesystem::path& path);

}  // namespace mapjoin
