// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A piece of work that is large by itself, and shares out work of its own.

#include <cstddef>
#include <functional>

namespace mapjoin {

/// Calls f. A thread that waits meanwhile for what f shares out takes up no other piece of those around f, so that no more of
/// these are under way than there are threads.
void isolated(const std::function<void()>& f);

/// How many pieces of work may be under way at a time: the threads of the caller.
std::size_t most_at_once();

}  // namespace mapjoin
