// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whole files, gzipped files and tar archives as bytes, for tests of readers.

#include <zlib.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace mapjoin::testing {

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Writes one gzip member holding `content` to `path`, or appends one.
inline std::filesystem::path write_gzip(const std::filesystem::path& path, std::string_view content, bool append = false) {
  const gzFile file = gzopen(path.c_str(), append ? "ab" : "wb");
  const auto size = static_cast<unsigned>(content.size());
  const bool written = file && (size == 0 || gzwrite(file, content.data(), size) == static_cast<int>(size));
  if (gzclose(file) != Z_OK || !written) throw std::runtime_error("cannot write " + path.string());
  return path;
}

/// The bytes of one member of a ustar archive: its header and its padded content.
inline std::string tar_member(const std::string& name, const std::string& bytes, char type = '0') {
  std::string header(512, '\0');
  const auto put = [&](std::size_t at, const std::string& text) { header.replace(at, text.size(), text); };
  char size[13];
  std::snprintf(size, sizeof size, "%011o", static_cast<unsigned>(bytes.size()));
  put(0, name);
  put(124, size);
  put(148, "        ");
  put(156, {type});
  put(257, std::string("ustar\00000", 8));
  unsigned sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  char checksum[8];
  std::snprintf(checksum, sizeof checksum, "%06o", sum);
  put(148, checksum);
  return header + bytes + std::string((512 - bytes.size() % 512) % 512, '\0');
}

/// The bytes of a ustar archive with these members.
inline std::string tar_of(const std::map<std::string, std::string>& members) {
  std::string tar;
  for (const auto& [name, bytes] : members) tar += tar_member(name, bytes);
  return tar + std::string(1024, '\0');
}

}  // namespace mapjoin::testing
