// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The elimination of a sum of quadratics, those that a tree of fronts has to take again.

#include <Eigen/Core>
#include <cstddef>
#include <mapjoin/join/incremental/front_factor.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// A quadratic xᵀHx over the entries of some variables, one after the other. Only the lower triangle of H counts. One of the
/// variables is FrontTree::kOne, whose value is 1: with δᵀHδ - 2bᵀδ + c, its row is -bᵀ, c.
struct Quadratic {
  std::vector<Variable> variables;
  Eigen::MatrixXd H;

  /// Of the whole symmetric matrix.
  double entry(Eigen::Index row, Eigen::Index column) const { return row < column ? H(column, row) : H(row, column); }
};

/// A sum of quadratics, and what its variables are.
struct QuadraticSum {
  struct Unknown {
    Variable variable;
    int dof = 0;
    int rank = 0;  ///< It is eliminated after all of lower rank that it is coupled to.
  };
  std::vector<Unknown> variables;            ///< Ascending, each once.
  std::vector<const Quadratic*> quadratics;  ///< Over these variables; none is over none.
};

/// A node of an elimination tree: a front, or a quadratic of the sum, which its parent takes.
struct SumNode {
  Front front;
  Quadratic update;                      ///< What the front sends to its parent, over its separator.
  std::optional<std::size_t> quadratic;  ///< Its number in the sum; nothing where the node is a front.
  std::size_t parent = 0;                ///< The number of nodes where there is none.
};

/// The elimination tree of the sum, children before their parents: each variable is in one front, and each quadratic a leaf.
std::vector<SumNode> eliminate(const QuadraticSum& sum);

}  // namespace mapjoin
