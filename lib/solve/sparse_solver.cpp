// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/solve/cholmod_solver.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>
#include <mapjoin/solve/sparse_solver.hpp>

namespace mapjoin {

std::unique_ptr<SparseSolver> make_solver(Engine engine) {
  if (engine == Engine::kCholmod) return std::make_unique<CholmodSolver>();
  return std::make_unique<SparseCholesky>();
}

}  // namespace mapjoin
