// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The BLAS in the command's own process: the room it needs, its threads, its name. A library leaves these to its host program.

#include <mapjoin/model/error.hpp>
#include <string>

namespace mapjoin::apps {

/// kTooLarge where a limit of the process (`ulimit -v`, `ulimit -d`) leaves less than the threads and their BLAS buffers take.
/// OpenBLAS asks again for ever for a buffer that it cannot have.
Expected<void> check_process_limits();

/// Ends OpenBLAS's own threads, which are as many as processors and spin for some 30 ms from the start: all threads are
/// TBB's. Under a limit, their buffers are taken first, so that no later call can lack one. Before the first BLAS call,
/// and before there is an Interruption: a signal that only one thread does not block goes to that thread.
void keep_blas_on_one_thread();

/// Version and build of OpenBLAS, or "BLAS" where it is another.
std::string blas_name();

}  // namespace mapjoin::apps
