// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/covariance_text.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {

/// Both formats.
void covariance_text(std::string_view bytes) {
  const TextScanner text("log.txt", bytes);
  for (const auto read : {read_odom_obs, read_map_circles}) {
    const auto log = read(text, {});
    check(log, "log.txt");
    if (log) check_round_trip(*log, LogFormat::kOdomObs);
  }
}

}  // namespace mapjoin::fuzz
