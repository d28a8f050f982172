// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A local map as a quadratic in the steps of its variables, and the error of that quadratic once they have moved.
//
// A variable is at x = retract(reference, δ). Linearised at δ̂, the residual of the map is r₀ - J δ with r₀ = r̂ + J δ̂ and J over
// δ: in space the columns of a rotation are those of the step at x̂ times the right Jacobian at δ̂.

#include <Eigen/Core>
#include <Eigen/LU>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/model/local_map.hpp>
#include <vector>

namespace mapjoin {

/// Dense indices of the variables and of the factors of the joined state.
using JoinedIndex = StrongIndex<struct JoinedTag>;
using FactorIndex = StrongIndex<struct FactorTag>;
/// The World as the base of a factor.
inline constexpr JoinedIndex kJoinedWorld = -1;

/// A pose or feature of the joined state.
template <int Dim>
struct JoinedVariable {
  bool is_pose = true;
  Pose<Dim> reference;                             ///< Reference of δ; for a feature its translation.
  PoseVector<Dim> step = PoseVector<Dim>::Zero();  ///< δ; for a feature its first entries.
  Pose<Dim> value;                                 ///< The estimate.
  Variable column = kConstant;                     ///< Variable of the linear system; kConstant if anchored.
  std::vector<FactorIndex> factors;

  int dof() const { return is_pose ? kPoseDof<Dim> : Dim; }
  void move_to(const PoseVector<Dim>& new_step);
  /// Makes the estimate the reference.
  void refer_to_value();
};

/// The right Jacobian J, of a step at x̂ in δ: R Exp(δ̂ + dδ) = R Exp(δ̂) Exp(J dδ + …).
template <int Dim>
RotationJacobian<Dim> right_jacobian(const RotationVector<Dim>& delta) {
  return right_jacobian_inverse(delta).inverse();
}

template <int Dim>
using JoinedVariables = Table<JoinedIndex, JoinedVariable<Dim>>;

template <int Dim>
class MapFactor {
 public:
  /// `variables` are those of the map's base, poses and features, with kJoinedWorld for the World as the base. `map` must
  /// outlive the factor.
  MapFactor(const LocalMap<Dim>& map, std::vector<JoinedIndex> variables);

  const std::vector<JoinedIndex>& variables() const { return variables_; }
  /// Measured rows.
  std::int64_t rows() const { return rows_; }
  /// Linearises the map: |r₀ - J δ|² in its information, over the columns of the variables that are not anchored.
  Quadratic linearise(const JoinedVariables<Dim>& variables);

  struct Fit {
    double chi2 = 0.0;
    /// The error of the linearisation, about its cost in chi2: eᵀWe for the error e of the residual, and φ²chi2 if the base has
    /// turned by φ since, which turns the gradient.
    double error = 0.0;
  };
  Fit fit(const JoinedVariables<Dim>& variables) const;
  double chi2(const JoinedVariables<Dim>& variables) const;

 private:
  /// The base as a variable; for the World one that is anchored at the origin.
  const JoinedVariable<Dim>& base_of(const JoinedVariables<Dim>& variables) const;
  const JoinedVariable<Dim>& target(const JoinedVariables<Dim>& variables, std::size_t t) const;
  Eigen::VectorXd residual_at(const JoinedVariables<Dim>& variables) const;

  const LocalMap<Dim>* map_;
  std::vector<JoinedIndex> variables_;
  std::int64_t rows_;
  LinearMap<Dim> linear_;                                        // with r₀ and J
  RotationVector<Dim> base_turn_ = RotationVector<Dim>::Zero();  // the base's in δ̂
};

}  // namespace mapjoin
