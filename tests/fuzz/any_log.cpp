// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/open.hpp>
#include <tests/fuzz/choices.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {

/// Runs open_log() on a file of any format.
void any_log(std::string_view bytes) {
  static const testing::TemporaryFolder folder;
  const auto path = folder.file("log", bytes);
  check(open_log(path, choices(bytes).options), path);
}

}  // namespace mapjoin::fuzz
