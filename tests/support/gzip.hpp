// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Gzip files for the tests of readers.

#include <zlib.h>

#include <filesystem>
#include <stdexcept>
#include <string_view>

namespace mapjoin::testing {

/// Writes one gzip member holding `content` to `path`, or appends one.
inline std::filesystem::path write_gzip(const std::filesystem::path& path, std::string_view content, bool append = false) {
  const gzFile file = gzopen(path.c_str(), append ? "ab" : "wb");
  const auto size = static_cast<unsigned>(content.size());
  const bool written = file && (size == 0 || gzwrite(file, content.data(), size) == static_cast<int>(size));
  if (gzclose(file) != Z_OK || !written) throw std::runtime_error("cannot write " + path.string());
  return path;
}

}  // namespace mapjoin::testing
