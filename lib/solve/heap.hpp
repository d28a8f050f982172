// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How malloc works in a program whose work is this library's.

namespace mapjoin {

/// Freed memory, up to 256 MB, is kept for the next iteration, not given back and zeroed anew; and the first 128 MB of the heap
/// are on large pages, where the kernel has any: they are touched for the first time two megabytes at once, not four kilobytes.
/// For the first line of main(), before there are threads. No result depends on it; without glibc's malloc it does nothing.
void prepare_heap();

}  // namespace mapjoin
