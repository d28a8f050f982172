// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/store/store.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>
#include <tests/support/store_checksums.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {

/// Reads a stranger's store, whose content must keep the promises of the model. Its checksums are made right first, or hardly
/// any input would get past them.
void store(std::string_view bytes) {
  static const testing::TemporaryFolder folder;
  const auto path = folder.file("maps.db", bytes);
  testing::seal(path);
  const auto any = read_store(path);
  if (!any) return check_error(any.error(), path);
  const auto check_all = [](const auto& stored) {
    check_log(stored.log);
    std::size_t maps = 0;
    for (const Segment& segment : stored.segments) maps += segment.is_map ? 1 : 0;
    promise(maps == stored.maps.size(), "every segment that is a map has one");
  };
  std::visit(check_all, *any);
}

}  // namespace mapjoin::fuzz
