// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The elimination of a sum of quadratics, the part of a tree of fronts that is eliminated again.

#include <Eigen/Core>
#include <cstddef>
#include <mapjoin/join/incremental/front_factor.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// A quadratic xᵀHx over the entries of some variables, one after the other. Only the lower triangle of H counts. One of the
/// variables is FrontTree::kOne, whose value is 1: for δᵀHδ - 2bᵀδ + c its row is -bᵀ, c.
struct Quadratic {
  std::vector<Variable> variables;
  Eigen::MatrixXd H;

  /// An entry of the whole symmetric matrix.
  double entry(Eigen::Index row, Eigen::Index column) const { return row < column ? H(column, row) : H(row, column); }
};

/// A sum of quadratics, and its variables.
struct QuadraticSum {
  struct Unknown {
    Variable variable;
    int dof = 0;
    int rank = 0;  ///< Eliminated after all of lower rank that the variable is coupled to.
  };
  std::vector<Unknown> variables;            ///< Ascending, each once.
  std::vector<const Quadratic*> quadratics;  ///< Quadratics, each over some of these variables.
};

/// A node of an elimination tree: a front, or a quadratic of the sum, which its parent takes.
struct SumNode {
  Front front;
  Quadratic update;                      ///< Update that the front sends to its parent, over its separator.
  std::optional<std::size_t> quadratic;  ///< Number of the quadratic in the sum; nullopt for a front.
  std::size_t parent = 0;                ///< Number of the parent; the number of nodes for a root.
};

/// The elimination tree of the sum, children before their parents: each variable is in one front, and each quadratic a leaf.
/// FrontTree::kOne must be the only variable of the highest rank; as its value is known, it makes no front singular.
std::vector<SumNode> eliminate(const QuadraticSum& sum);

}  // namespace mapjoin
