// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/mat_log.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {

void mat_log(std::string_view bytes) {
  const auto log = read_mat_log(bytes, "log.mat");
  check(log, "log.mat");
  if (log) check_round_trip(*log, LogFormat::kMat);
}

}  // namespace mapjoin::fuzz
