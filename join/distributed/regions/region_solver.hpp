// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Substructuring (Przemieniecki, 1963): each rank eliminates its own unknowns by fronts, and MUMPS those that ranks share.
//
//   A = Σ A_r,   A_r = ⎡ A_II  A_IB ⎤ ,   S = Σ (A_BB - A_BI A_II⁻¹ A_IB)
//                      ⎣ A_BI  A_BB ⎦

#include <mapjoin/distributed/mpi/mumps.hpp>
#include <mapjoin/distributed/regions/interface.hpp>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <mapjoin/solve/sparse_solver.hpp>

namespace mapjoin::distributed {

/// The engine of one rank, for a matrix A_r whose last blocks are shared with other ranks. Right-hand sides are sums over the
/// ranks, as A is; a solution has the same shared values on all ranks. Called by all ranks alike.
class RegionSolver final : public SparseSolver {
 public:
  /// `outer` are the unknowns of the last `outer_blocks` blocks.
  RegionSolver(const Communicator& comm, const OuterUnknowns& outer, std::size_t outer_blocks, const MumpsOptions& options);

  void analyse(const BlockLower& matrix) override { analyse(matrix, {}); }
  void analyse(const BlockLower& matrix, std::span<const GivenFront> given);
  /// Factorises; returns the singular columns of this rank's matrix, or its last one if another rank's matrix or S is singular.
  /// S counts as singular if it is not positive definite.
  std::vector<std::int64_t> factorise(const BlockLower& matrix) override { return factorise(matrix, {}); }
  std::vector<std::int64_t> factorise(const BlockLower& matrix, std::span<const GivenFront> given);
  Eigen::MatrixXd solve_columns(Eigen::MatrixXd B) const override;
  /// The supernode of a column among those that this rank eliminates alone.
  Supernode supernode_of(std::int64_t column) const override { return cholesky_.supernode_of(column); }
  std::size_t supernode_count() const override { return cholesky_.supernode_count(); }
  std::int64_t bytes() const override { return cholesky_.bytes(); }

  /// Makes room for the factor of what this rank eliminates alone, once analysed, and sees that there is room for its part of
  /// the factor of what ranks share. kCannotWrite, the same on all ranks, if a file cannot be made.
  Expected<void> make_room();
  /// The part of bytes() that is in memory.
  std::int64_t bytes_in_memory() const { return is_in_file_ ? 0 : bytes(); }
  /// Memory of MUMPS (10⁶ bytes) on the rank that needs most.
  double interface_megabytes() const { return outer_.size > 0 ? mumps_->megabytes() : 0.0; }
  /// True if the last factorisation found singular columns among those that this rank eliminates alone.
  bool is_singular_here() const { return is_singular_here_; }
  /// Directions that the last factorisation found free among these, at most so many, in elimination order; see SparseCholesky.
  Eigen::MatrixXd null_space_here(std::size_t most) const { return cholesky_.null_space(most); }

 private:
  const Communicator& comm_;
  const OuterUnknowns& outer_;
  SparseCholesky cholesky_;
  std::unique_ptr<Mumps> mumps_;
  bool is_in_file_;
  bool is_singular_here_ = false;
};

}  // namespace mapjoin::distributed
