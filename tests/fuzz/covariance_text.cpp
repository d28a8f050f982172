// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/covariance_text.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {

/// Runs the reader on a text of either of its formats.
void covariance_text(std::string_view bytes) {
  const auto log = read_covariance_text(TextScanner("log.txt", bytes), {});
  check(log, "log.txt");
  if (log) check_round_trip(*log, LogFormat::kOdomObs);
}

}  // namespace mapjoin::fuzz
