// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The lines of a plain g2o file whose first byte lies in the range of one rank, and what all ranks have to know of the file.

#include <filesystem>
#include <mapjoin/distributed/mpi/communicator.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::distributed {

struct TextPart {
  FileBytes bytes;           ///< Mapped, not read: the memory of a rank holds what it looks at.
  std::string_view text;     ///< Of this rank.
  std::size_t lines_before;  ///< In the file.
  bool has_graph = false;    ///< Whether any of its lines says something of a pose or a feature.

  std::vector<std::uint64_t> declared_poses;     ///< By the vertices of this rank, in the order of its lines.
  std::vector<std::uint64_t> declared_features;  ///< Likewise.
  std::vector<std::uint64_t> fixed;              ///< What the FIX lines of all ranks name.
  std::string parameters;                        ///< The PARAMS lines of the other ranks.

  /// The vertices of some poses in the text of this rank, as it has them.
  std::string vertices_of(const std::vector<std::uint64_t>& poses) const;
};

/// Bad input, the same on all ranks, where the file cannot be read or is not a plain g2o file.
Expected<TextPart> read_text_part(const Communicator& comm, const std::filesystem::path& path);

}  // namespace mapjoin::distributed
