// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A local map as a quadratic in the steps of its variables, and whether it still is one where these have gone meanwhile.
//
// A variable stands at x = retract(reference, δ). Linearised at δ̂, the map's residual is r₀ - J δ with r₀ = r̂ + J δ̂, J being
// over δ: in space a rotation's columns are those of the step at x̂ times the right Jacobian at δ̂.

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
/// As the base of a factor: the World.
inline constexpr JoinedIndex kJoinedWorld = -1;

/// A pose or feature of the joined state.
template <int Dim>
struct JoinedVariable {
  bool is_pose = true;
  Pose<Dim> reference;                             ///< Of a feature the translation.
  PoseVector<Dim> step = PoseVector<Dim>::Zero();  ///< δ; of a feature its first entries.
  Pose<Dim> value;                                 ///< The estimate.
  Variable column = kConstant;                     ///< The variable of the linear system; kConstant where it is anchored.
  std::vector<FactorIndex> factors;

  int dof() const { return is_pose ? kPoseDof<Dim> : Dim; }
  void move_to(const PoseVector<Dim>& new_step);
  /// Makes the estimate the reference.
  void refer_to_value();
};

/// Of a step at x̂ in δ: R Exp(δ̂ + dδ) = R Exp(δ̂) Exp(J dδ + …).
template <int Dim>
RotationJacobian<Dim> right_jacobian(const RotationVector<Dim>& delta) {
  return right_jacobian_inverse(delta).inverse();
}

template <int Dim>
using JoinedVariables = Table<JoinedIndex, JoinedVariable<Dim>>;

template <int Dim>
class MapFactor {
 public:
  /// `variables`: those of the map's base, poses and features; kJoinedWorld where the base is the World. `map` must stay.
  MapFactor(const LocalMap<Dim>& map, std::vector<JoinedIndex> variables);

  const std::vector<JoinedIndex>& variables() const { return variables_; }
  /// Measured rows.
  std::int64_t rows() const { return rows_; }
  /// |r₀ - J δ|² in the map's information, over the columns of the variables that are not held.
  Quadratic linearise(const JoinedVariables<Dim>& variables);

  struct Fit {
    double chi2 = 0.0;
    /// Of the linearisation, about what it may cost in chi2: eᵀWe for the error e of the residual, and φ²chi2 where the
    /// base has turned by φ since, which turns the gradient.
    double error = 0.0;
  };
  Fit fit(const JoinedVariables<Dim>& variables) const;
  double chi2(const JoinedVariables<Dim>& variables) const;

 private:
  /// The base as a variable, which for the World is one that is anchored at the origin.
  const JoinedVariable<Dim>& base_of(const JoinedVariables<Dim>& variables) const;
  const JoinedVariable<Dim>& target(const JoinedVariables<Dim>& variables, std::size_t t) const;
  Eigen::VectorXd residual_at(const JoinedVariables<Dim>& variables) const;

  const LocalMap<Dim>* map_;
  std::vector<JoinedIndex> variables_;
  std::int64_t rows_;
  LinearMap<Dim> linear_;                                        // with r₀ and J
  RotationVector<Dim> base_turn_ = RotationVector<Dim>::Zero();  // of δ̂
};

}  // namespace mapjoin
