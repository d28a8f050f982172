// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Pose graphs in TORO's text format: `VERTEX2 EDGE2` in the plane, `VERTEX3 EDGE3` in space.

#include <filesystem>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Whether a line that begins with `tag` is TORO's: its edges have the tags of iSAM's, its vertices are its own.
bool is_toro_vertex_tag(std::string_view tag);

/// The log in `text`, which stands at the begin of a file of lines
/// - `VERTEX2 i x y φ`, `EDGE2 i j dx dy dφ Wxx Wxy Wyy Wφφ Wxφ Wyφ` (mind the order), or
/// - `VERTEX3 i x y z roll pitch yaw`, `EDGE3 i j dx dy dz roll pitch yaw` and the upper triangle of W, row by row, over these
///   numbers; R = Rz(yaw) Ry(pitch) Rx(roll).
/// W is an information matrix; that of the three angles is turned to the rotation vector at the measurement.
Expected<AnyLog> read_toro(TextScanner text, const ReadOptions& options);

/// Edges and the values of poses, which the log must have (see write_edge_text()); features and their observations have no
/// place in it.
template <int Dim>
Expected<void> write_toro(const Log<Dim>& log, const std::filesystem::path& path);

}  // namespace mapjoin
