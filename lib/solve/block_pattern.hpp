// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The structure of a sparse least-squares problem, and the pattern of its H in elimination order.

#include <mapjoin/solve/block_lower.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <vector>

namespace mapjoin {

/// The variables of a problem, and those that each factor ties together.
struct BlockPattern {
  Table<Variable, int> dofs;             ///< Entries of each variable.
  Lists<std::size_t, Variable> factors;  ///< A factor's variables, kConstant for one that is held.
};

/// True for each factor that alone ties a variable, and all that hangs on it, to the others and to what is held.
std::vector<bool> lone_ties(const BlockPattern& pattern);

/// An order in which the variables of a pattern are eliminated.
struct Elimination {
  explicit Elimination(const BlockPattern& pattern, const Ordering& ordering = {});

  Table<Column, Variable> order;
  Table<Variable, Column> column;  ///< The inverse of `order`.
  BlockLower matrix;               ///< The pattern of H in this order, without values.
};

}  // namespace mapjoin
