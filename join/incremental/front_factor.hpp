// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The factor of a growing sum of quadratics: fronts, each with its parent, and the covariances that they give.

#include <Eigen/Core>
#include <mapjoin/join/incremental/shared_table.hpp>
#include <mapjoin/solve/block_pattern.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace mapjoin {

/// Variables that are eliminated together. A front in the tree never changes; another one may replace it.
struct Front {
  std::vector<Variable> frontals;
  std::vector<Variable> separator;  ///< Variables eliminated later on which the frontals depend.
  Eigen::MatrixXd L;                ///< Columns of the factor, over frontals, then the separator.
  bool is_singular = false;         ///< True if it eliminates a variable that nothing determines.

  /// The entries of the frontals that cost least given those of the separator.
  Eigen::VectorXd solved(const Eigen::VectorXd& separator) const;
};

/// The factor of a sum of quadratics by fronts, each with its parent. A copy by kept() never changes.
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
    NodeIndex node = kNone;  ///< Node that eliminates the variable.
  };

  /// The joint marginal covariance of different variables, one after the other, with the sum's H as the information; nullopt if
  /// a front between one of them and the root is singular, or one of them is in no front. A deferred front (DeferredFront) adds
  /// its own variables, as a leaf that the tree does not have yet.
  std::optional<Eigen::MatrixXd> covariance(std::span<const Variable> of, const Front* deferred = nullptr) const;
  /// RᵀPR for the covariance P of different variables, R having their rows. Otherwise as covariance().
  std::optional<Eigen::MatrixXd> inverse_form(std::span<const Variable> of, const Eigen::MatrixXd& R,
                                              const Front* deferred = nullptr) const;
  FrontFactor kept() { return {variables.kept(), nodes.kept()}; }

  SharedTable<Variable, Eliminated> variables;
  SharedTable<NodeIndex, Node> nodes;

 private:
  /// The fronts that eliminate variables and all fronts above them, each before those above; the deferred one first.
  std::vector<const Front*> way_to_root(std::span<const Variable> of, const Front* deferred) const;
};

}  // namespace mapjoin
