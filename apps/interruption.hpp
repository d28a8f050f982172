// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// SIGINT and SIGTERM as a stop token.

#include <stop_token>

namespace mapjoin::apps {

/// From its construction to the end of the process, SIGINT and SIGTERM request a stop instead of ending it. To be made once.
/// SIGPIPE is ignored: a reader that has gone away shows when writing.
class Interruption {
 public:
  Interruption();
  std::stop_token token() const { return source_.get_token(); }
  /// Whether a signal has come. The token hears of it a moment later: a call that the signal ended may be back before.
  bool has_come() const;

 private:
  std::stop_source source_;
};

}  // namespace mapjoin::apps
