// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A Cholesky factor seen by runs of columns with the same rows.

#include <cstdint>
#include <vector>

namespace mapjoin {

/// Columns [begin, end) of L as one dense block.
struct Supernode {
  std::int64_t begin = 0;
  std::int64_t end = 0;
  std::vector<std::int64_t> rows;  ///< Ascending: its own columns, then the rows below them.
  const double* values = nullptr;  ///< rows.size() × (end - begin), column by column. What is above the diagonal is ignored.
  const double* update =
      nullptr;            ///< The front's update of the rows below, square, by its lower triangle; null where not kept.
  std::size_t given = 0;  ///< Of a front without columns, which was eliminated before, its number.
};

/// A view of L, A = L Lᵀ, in the order of its columns; it holds until A is factorised again.
using Supernodes = std::vector<Supernode>;

}  // namespace mapjoin
