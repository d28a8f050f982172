// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The factor of a growing sum of quadratics: fronts, each with its parent, and what they say of variables.

#include <Eigen/Core>
#include <mapjoin/join/incremental/shared_table.hpp>
#include <mapjoin/solve/block_pattern.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace mapjoin {

/// Variables that are eliminated together. Once it is in the tree it stays as it is, until another one takes its place.
struct Front {
  std::vector<Variable> frontals;
  std::vector<Variable> separator;  ///< Of those eliminated later, the variables that the frontals depend on.
  Eigen::MatrixXd L;                ///< Over frontals, then the separator.
  bool is_singular = false;         ///< Eliminates what nothing determines.

  /// The frontals' entries where they cost least, given those of the separator.
  Eigen::VectorXd solved(const Eigen::VectorXd& separator) const;
};

/// The factor of a sum of quadratics by fronts, each with its parent. A copy by kept() stays as it is.
class FrontFactor {
 public:
  using NodeIndex = StrongIndex<struct NodeTag>;
  static constexpr NodeIndex kNone = -1;
  struct Node {
    std::shared_ptr<const Front> front;
    NodeIndex parent = kNone;
  };
  struct Eliminated {
    int dof = 0;
    NodeIndex node = kNone;  ///< That eliminates the variable.
  };

  /// The joint marginal covariance of different variables, one after the other, the sum's H being the information; nothing
  /// where a front between one of them and the root eliminates what nothing determines. With a deferred front (DeferredFront)
  /// that of its variables, too, which are solved for by those of the tree, of which it is not yet a part.
  std::optional<Eigen::MatrixXd> covariance(std::span<const Variable> of, const Front* deferred = nullptr) const;
  /// RᵀPR for that covariance P, the rows of R being those of the variables.
  std::optional<Eigen::MatrixXd> inverse_form(std::span<const Variable> of, const Eigen::MatrixXd& R,
                                              const Front* deferred = nullptr) const;
  FrontFactor kept() { return {variables.kept(), nodes.kept()}; }

  SharedTable<Variable, Eliminated> variables;
  SharedTable<NodeIndex, Node> nodes;

 private:
  /// The fronts that eliminate these and all above them, each before those above; the deferred one first.
  std::vector<const Front*> way_to_root(std::span<const Variable> of, const Front* deferred) const;
};

}  // namespace mapjoin
