// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The engine `cholmod`: SuiteSparse's factorisation (Chen, Davis, Hager & Rajamanickam, 2008).

#include <mapjoin/solve/sparse_solver.hpp>

namespace mapjoin {

/// CHOLMOD on the calling thread, in the order of the matrix.
class CholmodSolver final : public SparseSolver {
 public:
  /// Supernodal if asked for and the library has it, otherwise simplicial.
  explicit CholmodSolver(bool is_supernodal = true);
  ~CholmodSolver() override;
  CholmodSolver(const CholmodSolver&) = delete;
  CholmodSolver& operator=(const CholmodSolver&) = delete;

  void analyse(const BlockLower& matrix) override;
  /// Returns the first singular column alone.
  std::vector<std::int64_t> factorise(const BlockLower& matrix) override;
  Eigen::MatrixXd solve_columns(Eigen::MatrixXd B) const override;
  Supernode supernode_of(std::int64_t column) const override;
  std::size_t supernode_count() const override;
  std::int64_t bytes() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mapjoin
