// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/angle_text.hpp>
#include <mapjoin/io/formats/covariance_text.hpp>
#include <tests/fuzz/choices.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {
namespace {

void check_text(std::string_view bytes, const EdgeText<2>& plane, const EdgeText<3>* space, LogFormat format) {
  const auto log = read_edge_text(TextScanner("log.txt", bytes), plane, space, choices(bytes).options);
  check(log, "log.txt");
  if (log) check_round_trip(*log, format);
}

}  // namespace

void toro(std::string_view bytes) {
  check_text(bytes, kToroPlane, &kToroSpace, LogFormat::kToro);
}

void isam(std::string_view bytes) {
  check_text(bytes, kIsamPlane, &kIsamSpace, LogFormat::kIsam);
}

void gtsam_text(std::string_view bytes) {
  check_text(bytes, kGtsamText, nullptr, LogFormat::kGtsam);
}

}  // namespace mapjoin::fuzz
