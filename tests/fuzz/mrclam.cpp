// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/mrclam/mrclam.hpp>
#include <tests/fuzz/folder.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {

void mrclam(std::string_view bytes) {
  static Folder folder;
  folder.hold(files_in(bytes));
  const auto log = read_mrclam(folder.path());
  check(log, folder.path());
  if (log) check_round_trip(*log, LogFormat::kG2o);
}

}  // namespace mapjoin::fuzz
