// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The options of readers, chosen by the text that they read in such a way that it stays a file of its format.

#include <algorithm>
#include <cstddef>
#include <mapjoin/io/read_options.hpp>
#include <string_view>

namespace mapjoin::fuzz {

/// Choices by a comment `#OP…` in the first line: the bits of O are options of the reader, the code of P is a number of bytes.
struct Choices {
  ReadOptions options;
  std::size_t piece_bytes = 64;
};

inline Choices choices(std::string_view text) {
  Choices chosen;
  if (text.size() < 3 || text[0] != '#') return chosen;
  const auto bits = static_cast<unsigned char>(text[1]);
  if (bits & 1) chosen.options.pose_error = PoseError::kG2o;
  if (bits & 2) chosen.options.rotation_information = RotationInformation::kQuaternion;
  chosen.options.repair_information = (bits & 4) != 0;
  chosen.options.skip_unknown = (bits & 8) != 0;
  chosen.options.skip_self_edges = (bits & 16) != 0;
  chosen.options.identity_where_missing = (bits & 32) != 0;
  if (bits & 64) chosen.options.undeclared = Undeclared::kSkipped;
  chosen.piece_bytes = std::max<std::size_t>(1, static_cast<unsigned char>(text[2]));
  return chosen;
}

}  // namespace mapjoin::fuzz
