// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A local map as a quadratic in the steps of its variables, and whether it still is one where these have gone meanwhile.
//
// A variable stands at x = retract(reference, δ). Linearised at δ̂, the map's residual is r̂ - J (δ - δ̂), with J over δ: in space
// a rotation's columns are those of the step at x̂ times the right Jacobian at δ̂.

#include <Eigen/Core>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <vector>

namespace mapjoin {

/// A pose or feature of the joined state.
template <int Dim>
struct JoinedVariable {
  bool is_pose = true;
  Index index = 0;                                 ///< Among poses, or among features.
  Pose<Dim> reference;                             ///< Of a feature the translation.
  PoseVector<Dim> step = PoseVector<Dim>::Zero();  ///< δ; of a feature its first entries.
  Pose<Dim> value;                                 ///< The estimate.
  Index column = kConstant;                        ///< The variable of the linear system; kConstant where it is held.
  std::vector<Index> factors;

  int dof() const { return is_pose ? kPoseDof<Dim> : Dim; }
  void move_to(const PoseVector<Dim>& new_step);
  /// Makes the estimate the reference.
  void refer_to_value();
};

template <int Dim>
using JoinedVariables = std::vector<JoinedVariable<Dim>>;

template <int Dim>
class MapFactor {
 public:
  /// `slots`: the variables of the map's base, poses and features; kWorld where the base is the World. `map` must stay.
  MapFactor(const LocalMap<Dim>& map, std::vector<Index> slots);

  const std::vector<Index>& slots() const { return slots_; }
  /// Measured rows.
  std::int64_t rows() const { return rows_; }
  /// Over the columns of the variables.
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
  Pose<Dim> base_of(const JoinedVariables<Dim>& variables) const;
  Eigen::VectorXd residual_at(const JoinedVariables<Dim>& variables) const;
  /// The step of a slot since the linearisation.
  PoseVector<Dim> moved(const JoinedVariables<Dim>& variables, std::size_t slot) const;

  const LocalMap<Dim>* map_;
  std::vector<Index> slots_;
  std::int64_t rows_;
  LinearMap<Dim> linear_;
  std::vector<PoseVector<Dim>> steps_;  // δ̂ per slot
};

}  // namespace mapjoin
