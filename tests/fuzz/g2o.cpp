// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/g2o/g2o.hpp>
#include <tests/fuzz/choices.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {

/// Runs the reader on the whole text and on small pieces of it, which must give the same log, or the same error.
void g2o(std::string_view bytes) {
  const auto [options, piece_bytes] = choices(bytes);
  const TextScanner text("log.g2o", bytes);
  const auto log = read_g2o(text, options);
  check(log, "log.g2o");
  const auto in_pieces = read_g2o(text, options, {.piece_bytes = piece_bytes});
  promise(in_pieces.has_value() == log.has_value(), "pieces are right where the whole is");
  if (!log) {
    promise(in_pieces.error().message == log.error().message, "pieces are wrong where the whole is");
    return;
  }
  promise(bits_of(*in_pieces) == bits_of(*log), "in pieces the log is the same");
  check_round_trip(*log, LogFormat::kG2o);
}

}  // namespace mapjoin::fuzz
