// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/io/files/archive.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {

/// Visits the members of an archive, all of which must lie within it, and reads those named as local maps.
void archive(std::string_view bytes) {
  static const testing::TemporaryFolder folder;
  const auto path = folder.file("maps.tar", bytes);
  std::size_t ones = 0;
  const auto all = [](const std::string&) { return true; };
  const auto count = [&](const std::filesystem::path&, std::string_view content) -> Expected<void> {
    ones += static_cast<std::size_t>(std::count(content.begin(), content.end(), '1'));  // Touches every byte.
    return {};
  };
  if (const auto done = visit_files(path, all, count); !done) check_error(done.error(), path);
  promise(ones <= bytes.size() << 11, "members are no more than the archive");
  check(read_local_map_set(path), path);
}

}  // namespace mapjoin::fuzz
