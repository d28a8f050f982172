// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The command's own process: its limits, the threads of its BLAS, its signals. A library leaves these to its host program.

#include <mapjoin/model/error.hpp>
#include <stop_token>
#include <string>

namespace mapjoin::apps {

/// Puts something in the place of each standard stream that is closed, so that no file which is opened later takes the place
/// and what is written there. Writing to standard output then fails, also by /dev/stdout. To be called before any file is
/// opened.
void occupy_standard_streams();

/// Checks the limits of the process (`ulimit -v`, `ulimit -d`): kTooLarge if they leave less than the threads and their BLAS
/// buffers take, for OpenBLAS asks again for ever for a buffer that it cannot have.
Expected<void> check_process_limits();

/// Ends OpenBLAS's own threads, as many as processors, which spin for some 30 ms from the start: all threads are TBB's. Under a
/// limit, takes the buffers of all threads first, so that no later call can lack one. To be called before the first BLAS call,
/// and before there is an Interruption: a signal that only one thread does not block goes to that thread.
void keep_blas_on_one_thread();

/// Version and build of OpenBLAS, or "BLAS" for another library.
std::string blas_name();

/// Makes SIGBUS end the process with a sentence and the exit code of bad input. Files are mapped into memory, and if another
/// process cuts one short while it is read, SIGBUS comes for the missing pages.
void end_on_truncated_input();

/// Turns signals into a stop request, from its construction to the end of the process: the first SIGINT or SIGTERM requests a
/// stop, and ends reads and writes that wait; a second one, more than 0.2 s later, ends the process at once. To be made once,
/// before other threads are. SIGPIPE and SIGXFSZ are ignored: a reader that has gone away, or a file that grows too large,
/// shows when writing.
class Interruption {
 public:
  Interruption();
  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
};

/// Lets the calling thread, the main one, wait in reads and writes from now on though a stop is requested: for work that a stop
/// does not end. A second signal still ends the process.
void wait_despite_stop();

}  // namespace mapjoin::apps
