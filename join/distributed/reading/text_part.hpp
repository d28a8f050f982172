// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The lines of a plain g2o file whose first byte lies in the range of one rank, and what all ranks need to know of the file.

#include <filesystem>
#include <mapjoin/distributed/mpi/communicator.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::distributed {

struct TextPart {
  FileBytes bytes;           ///< The file, mapped and not read: only what a rank looks at takes its memory.
  std::string_view text;     ///< The lines of this rank.
  std::size_t lines_before;  ///< Number of lines of the file before `text`.
  bool has_graph = false;    ///< True if any of its lines mentions a pose or a feature.

  std::vector<std::uint64_t> declared_poses;     ///< Ids of the pose vertices of this rank, in the order of its lines.
  std::vector<std::uint64_t> declared_features;  ///< Ids of the feature vertices of this rank, in the order of its lines.
  std::vector<std::uint64_t> fixed;              ///< Ids in the FIX lines of all ranks, ascending, each once.
  std::optional<std::uint64_t> first_fixed;      ///< The first id in them.
  std::string parameters;                        ///< The PARAMS lines of the other ranks.

  /// The vertex lines of some poses, given by ascending ids, in the text of this rank, verbatim.
  std::string vertices_of(const std::vector<std::uint64_t>& poses) const;
};

/// Reads the lines of this rank. kBadInput, the same on all ranks, if the file cannot be read or is not a plain g2o file.
Expected<TextPart> read_text_part(const Communicator& comm, const std::filesystem::path& path);

}  // namespace mapjoin::distributed
