// SPDX-License-Identifier: BSD-3-Clause
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <mapjoin/parallel/isolated.hpp>

namespace mapjoin {

void isolated(const std::function<void()>& f) {
  tbb::this_task_arena::isolate([&] { f(); });
}

std::size_t most_at_once() {
  return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
}

}  // namespace mapjoin
