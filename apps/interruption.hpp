// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// SIGINT and SIGTERM as a stop token.

#include <stop_token>

namespace mapjoin::apps {

/// From its construction to the end of the process, the first SIGINT or SIGTERM requests a stop, and ends reads and writes
/// that wait; the second one ends the process at once. To be made once, before other threads are.
/// SIGPIPE and SIGXFSZ are ignored: a reader that has gone away, or a file that grows too large, shows when writing.
class Interruption {
 public:
  Interruption();
  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
};

}  // namespace mapjoin::apps
