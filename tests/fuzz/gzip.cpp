// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/files/file_bytes.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {

/// Reads a file, whose bytes must be given as they are, or inflated up to the limit.
void gzip(std::string_view bytes) {
  constexpr std::size_t kMost = 1 << 16;
  static const testing::TemporaryFolder folder;
  const auto path = folder.file("file.gz", bytes);
  const auto content = FileBytes::read(path, kMost);
  if (!content) return check_error(content.error(), path);
  const bool is_gzip = bytes.starts_with("\x1f\x8b");
  promise(is_gzip ? content->view().size() <= kMost : content->view() == bytes, "the content is what is in the file");
}

}  // namespace mapjoin::fuzz
