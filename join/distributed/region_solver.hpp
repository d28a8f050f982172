// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Substructuring (Przemieniecki, 1963): each rank eliminates the interior of its region by the fronts, MUMPS what regions
// share.
//
//   A = Σ A_r,   A_r = ⎡ A_II  A_IB ⎤ ,   S = Σ (A_BB - A_BI A_II⁻¹ A_IB)
//                      ⎣ A_BI  A_BB ⎦

#include <mapjoin/distributed/interface.hpp>
#include <mapjoin/distributed/mumps.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>
#include <mapjoin/solve/sparse_solver.hpp>

namespace mapjoin::distributed {

/// The engine of one rank, for a matrix A_r whose last blocks are the interface of its region. Right-hand sides are sums over
/// the ranks as A is; a solution has the same values of the interface on all ranks. Called by all ranks alike.
class RegionSolver final : public SparseSolver {
 public:
  RegionSolver(const Communicator& comm, const Interface& interface, const MumpsOptions& options);

  void analyse(const BlockLower& matrix) override;
  /// Columns of this rank's matrix; where another rank's or S is singular, the last one. S is said to be where it is not
  /// positive definite.
  std::vector<std::int64_t> factorise(const BlockLower& matrix) override;
  Eigen::MatrixXd solve_columns(Eigen::MatrixXd B) const override;
  /// Of this rank's interior.
  Supernodes supernodes() const override { return cholesky_.supernodes(); }
  std::size_t supernode_count() const override { return cholesky_.supernode_count(); }
  std::int64_t bytes() const override { return cholesky_.bytes(); }

  /// What MUMPS takes on the rank that needs most (10⁶ bytes).
  double interface_megabytes() const { return interface_.size > 0 ? mumps_->megabytes() : 0.0; }
  /// Whether the last factorisation met something singular in the interior of this rank's region.
  bool is_singular_here() const { return is_singular_here_; }

 private:
  const Communicator& comm_;
  const Interface& interface_;
  SparseCholesky cholesky_;
  std::unique_ptr<Mumps> mumps_;
  bool is_singular_here_ = false;
};

}  // namespace mapjoin::distributed
