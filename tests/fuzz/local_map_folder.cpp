// SPDX-License-Identifier: BSD-3-Clause
#include <tests/fuzz/folder.hpp>
#include <tests/fuzz/local_map.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {

void local_map_folder(std::string_view bytes) {
  static Folder folder;
  folder.hold(files_in(bytes));
  const auto set = read_local_map_set(folder.path());
  check(set, folder.path());
  if (set) check_round_trip(*set, LocalMapFormat::kText);
}

}  // namespace mapjoin::fuzz
