// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// In which fronts a part of a system is eliminated: order, structure, and what is eliminated together.

#include <mapjoin/model/ids.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <vector>

namespace mapjoin {

/// Variables that are eliminated together, and those that this ties together.
struct PlannedFront {
  std::vector<Index> frontals;
  std::vector<Index> separator;
  Index parent = -1;  ///< The front that eliminates the first of the separator; -1 where that is empty.
};

struct FrontPlan {
  std::vector<PlannedFront> fronts;    ///< Parents before their children.
  std::vector<Index> front_of_clique;  ///< The front that eliminates the first variable of each clique.
};

/// Variables 0, 1, … of the given degrees of freedom, each of the cliques without repetition or constants and not empty.
/// The `last_count` last variables are eliminated after all others, which come in an order of little fill. Fronts are merged
/// with their parents where that costs few zeros.
FrontPlan plan_fronts(const std::vector<int>& dofs, const Cliques& cliques, Index last_count);

}  // namespace mapjoin
