// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What becomes of a run whose input is cut short by another process while it is read.

namespace mapjoin::apps {

/// Files are mapped into memory, and where one is cut short SIGBUS comes for the pages that are gone: from here on it ends the
/// process with a sentence and the exit code of bad input.
void end_on_truncated_input();

}  // namespace mapjoin::apps
