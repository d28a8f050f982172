// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A kept estimate: its values, and the factor that gives covariances.

#include <Eigen/Core>
#include <mapjoin/join/incremental/front_factor.hpp>
#include <mapjoin/join/incremental/map_factor.hpp>
#include <mapjoin/join/incremental/shared_table.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace mapjoin {

/// The variables of an estimate as its last settling left them.
template <int Dim>
class ShownVariables {
 public:
  struct Variable {
    bool is_pose = true;
    Pose<Dim> value;                                         ///< The estimate; for a feature its translation.
    RotationVector<Dim> turn = RotationVector<Dim>::Zero();  ///< Turn of a pose since the reference of the linear system (rad).
    mapjoin::Variable column = kConstant;                    ///< Variable of the linear system; kConstant if anchored.

    int dof() const { return is_pose ? kPoseDof<Dim> : Dim; }
  };
  using Kept = SharedTable<JoinedIndex, Variable>;

  /// Marks a variable that moves.
  void note_moving(JoinedIndex v);
  /// Shows the present values of variables that have moved or are new. Returns the largest move of one that was shown before.
  StepSize show(const JoinedVariables<Dim>& variables);
  Kept kept() { return shown_.kept(); }

 private:
  Kept shown_;
  std::vector<JoinedIndex> moving_;  // variables marked, each once, none that is new
  Table<JoinedIndex, bool> is_moving_;
};

/// The estimate of a settling. It never changes, so any thread may read it.
template <int Dim>
struct KeptEstimate {
  /// The joint marginal covariance of the steps of different variables at their values, a row for each entry: zero for anchored
  /// ones; nullopt if one may not be determined (see FrontFactor).
  std::optional<Eigen::MatrixXd> covariance(std::span<const JoinedIndex> of) const;

  typename ShownVariables<Dim>::Kept variables;
  FrontFactor factor;
  std::shared_ptr<const Front> deferred;  ///< Front of variables that the factor does not have yet, or null.
  double chi2 = 0.0;
  std::int64_t dof = 0;
};

}  // namespace mapjoin
