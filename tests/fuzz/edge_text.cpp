// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/angle_text.hpp>
#include <mapjoin/io/formats/covariance_text.hpp>
#include <tests/fuzz/choices.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {
namespace {

void check_text(std::string_view bytes, Expected<AnyLog> (*read)(TextScanner, const ReadOptions&), LogFormat format) {
  const auto log = read(TextScanner("log.txt", bytes), choices(bytes).options);
  check(log, "log.txt");
  if (log) check_round_trip(*log, format);
}

}  // namespace

void toro(std::string_view bytes) {
  check_text(bytes, read_toro, LogFormat::kToro);
}

void isam(std::string_view bytes) {
  check_text(bytes, read_isam, LogFormat::kIsam);
}

void gtsam_text(std::string_view bytes) {
  check_text(bytes, read_gtsam_text, LogFormat::kGtsam);
}

}  // namespace mapjoin::fuzz
