// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Sharing out a factorisation, and the solves with it, among threads.

#include <functional>
#include <mapjoin/solve/supernodal_tree.hpp>

namespace mapjoin {

/// Cuts the tree where independent subtrees are worth a task. Depends on the tree only.
FactorTask factor_tasks(const SupernodalTree& tree);

/// Calls f(supernode) for each after all its children; side by side where tasks are independent.
void for_each_upwards(const FactorTask& tasks, const std::function<void(std::size_t)>& f);
/// Calls f(supernode) for each after its parent.
void for_each_downwards(const FactorTask& tasks, const std::function<void(std::size_t)>& f);

}  // namespace mapjoin
