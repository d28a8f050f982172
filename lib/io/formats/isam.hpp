// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Logs in iSAM's text format: `EDGE2 LANDMARK` in the plane, `EDGE3 POINT3` in space, with square roots of information
// matrices.

#include <filesystem>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Whether a line of an iSAM log may begin with `tag`.
bool is_isam_tag(std::string_view tag);

/// The log in `text`, which stands at the begin of a file of lines
/// - `EDGE2 i j dx dy dφ S`, `LANDMARK i feature x y S`, or
/// - `EDGE3 i j dx dy dz roll pitch yaw S`, `POINT3 i feature x y z S`, with R = Rz(yaw) Ry(pitch) Rx(roll).
/// S is the upper triangle, row by row, of a square root of the information matrix, W = SᵀS, over the numbers of the line in
/// their order; W of the three angles is turned to the rotation vector with the Jacobian at the measurement, which is bad input
/// where the pitch is a right angle. Poses and features are named apart.
Expected<AnyLog> read_isam(TextScanner text, const ReadOptions& options);

/// Edges and observations (see write_edge_text()). The square root is rounded, and so are the angles in space.
template <int Dim>
Expected<void> write_isam(const Log<Dim>& log, const std::filesystem::path& path);

}  // namespace mapjoin
