// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/solve/cholmod.hpp>
#include <mapjoin/solve/engines/cholmod_solver.hpp>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <mutex>

// Null if CHOLMOD was built without OpenMP.
extern "C" {
[[gnu::weak]] int omp_get_max_active_levels();
[[gnu::weak]] void omp_set_max_active_levels(int levels);
}

namespace mapjoin {
namespace {

/// Keeps CHOLMOD's loops on the calling thread. (Debian's opens four threads whatever OMP_NUM_THREADS says.)
class OneThread {
 public:
  OneThread() : levels_(omp_get_max_active_levels ? omp_get_max_active_levels() : 0) { set(0); }
  ~OneThread() { set(levels_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  static void set(int levels) {
    if (omp_set_max_active_levels) omp_set_max_active_levels(levels);
  }
  int levels_;
};

}  // namespace

struct CholmodSolver::State {
  Cholmod cholmod;
  // The lower triangle of A, entry by entry.
  std::vector<SuiteSparse_long> begin;
  std::vector<SuiteSparse_long> rows;
  std::vector<double> values;
  std::vector<std::int64_t> source;  ///< Place of each entry in the values of the blocks.
  cholmod_factor* L = nullptr;       ///< Null before analyse().
  std::mutex solving;                ///< Held by solves, which write to CHOLMOD's workspace.

  ~State() { forget_factor(); }
  void forget_factor() {
    if (L) cholmod_l_free_factor(&L, cholmod.get());
  }
  cholmod_sparse view() {
    cholmod_sparse A = sparse_view(begin, rows, values.data(), Triangle::kLower);
    A.sorted = 1;
    return A;
  }
  void take_pattern(const BlockLower& matrix);
};

void CholmodSolver::State::take_pattern(const BlockLower& matrix) {
  begin.assign(1, 0);
  rows.clear();
  source.clear();
  for (const Column k : matrix.columns()) {
    for (Eigen::Index j = 0; j < matrix.dof(k); ++j) {
      std::int64_t from = matrix.first_value[k] + j * matrix.heights[k];
      for (const Column block : matrix.rows[k]) {
        for (auto row = matrix.offsets[block]; row < matrix.offsets[block + 1]; ++row, ++from) {
          if (row < matrix.offsets[k] + j) continue;
          rows.push_back(row);
          source.push_back(from);
        }
      }
      begin.push_back(static_cast<SuiteSparse_long>(rows.size()));
    }
  }
  values.resize(rows.size());
}

CholmodSolver::CholmodSolver(bool is_supernodal) : state_(std::make_unique<State>()) {
  Cholmod& cholmod = state_->cholmod;
  cholmod->nmethods = 1;
  cholmod->method[0].ordering = CHOLMOD_NATURAL;
  cholmod->postorder = 0;
  cholmod->supernodal = is_supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
  cholmod->final_ll = 1;
}

CholmodSolver::~CholmodSolver() = default;

void CholmodSolver::analyse(const BlockLower& matrix) {
  State& state = *state_;
  const OneThread one_thread;
  state.forget_factor();
  state.take_pattern(matrix);
  cholmod_sparse A = state.view();
  state.L = cholmod_l_analyze(&A, state.cholmod.get());
  if (state.cholmod->status == CHOLMOD_NOT_INSTALLED) {
    state.cholmod->supernodal = CHOLMOD_SIMPLICIAL;
    state.L = cholmod_l_analyze(&A, state.cholmod.get());
  }
  state.cholmod.check();
}

std::vector<std::int64_t> CholmodSolver::factorise(const BlockLower& matrix) {
  State& state = *state_;
  const OneThread one_thread;
  for (std::size_t e = 0; e < state.values.size(); ++e) {
    state.values[e] = matrix.values[static_cast<std::size_t>(state.source[e])];
  }
  cholmod_sparse A = state.view();
  cholmod_l_factorize(&A, state.L, state.cholmod.get());
  state.cholmod.check();
  const auto diagonal = [&](std::int64_t column) {
    return state.values[static_cast<std::size_t>(state.begin[static_cast<std::size_t>(column)])];
  };
  // L is not computed beyond the minor that is not positive definite.
  const auto regular = static_cast<std::int64_t>(state.L->minor);
  for (const Supernode& node : supernodes()) {
    const auto height = static_cast<std::int64_t>(node.rows.size());
    for (std::int64_t j = node.begin; j < std::min(node.end, regular); ++j) {
      if (has_lost_digits(node.values[(j - node.begin) * (height + 1)], diagonal(j))) return {j};
    }
  }
  return regular < static_cast<std::int64_t>(state.L->n) ? std::vector{regular} : std::vector<std::int64_t>();
}

Eigen::MatrixXd CholmodSolver::solve_columns(Eigen::MatrixXd B) const {
  const std::lock_guard lock(state_->solving);
  const OneThread one_thread;
  cholmod_dense b{};
  b.nrow = b.d = static_cast<std::size_t>(B.rows());
  b.ncol = static_cast<std::size_t>(B.cols());
  b.nzmax = static_cast<std::size_t>(B.size());
  b.x = B.data();
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod_l_solve(CHOLMOD_A, state_->L, &b, state_->cholmod.get());
  state_->cholmod.check();
  std::copy_n(static_cast<const double*>(x->x), B.size(), B.data());
  cholmod_l_free_dense(&x, state_->cholmod.get());
  return B;
}

Supernode CholmodSolver::supernode_of(std::int64_t column) const {
  const cholmod_factor& L = *state_->L;
  const auto list = [](const void* values) { return static_cast<const SuiteSparse_long*>(values); };
  const auto* x = static_cast<const double*>(L.x);
  if (!L.is_super) {
    const SuiteSparse_long first = list(L.p)[column];
    const SuiteSparse_long* rows = list(L.i) + first;
    return {column, column + 1, {rows, rows + list(L.nz)[column]}, x + first};
  }
  const SuiteSparse_long* ends = list(L.super) + 1;
  const auto s = std::upper_bound(ends, ends + L.nsuper, column) - ends;
  return {list(L.super)[s], ends[s], {list(L.s) + list(L.pi)[s], list(L.s) + list(L.pi)[s + 1]}, x + list(L.px)[s]};
}

std::size_t CholmodSolver::supernode_count() const {
  if (!state_->L) return 0;
  return state_->L->is_super ? state_->L->nsuper : state_->L->n;
}

std::int64_t CholmodSolver::bytes() const {
  if (!state_->L) return 0;
  const double entries = state_->L->is_super ? static_cast<double>(state_->L->xsize) : state_->cholmod->lnz;
  return static_cast<std::int64_t>(entries * sizeof(double));
}

std::unique_ptr<SparseSolver> make_solver(Engine engine) {
  if (engine == Engine::kCholmod) return std::make_unique<CholmodSolver>();
  return std::make_unique<SparseCholesky>();
}

}  // namespace mapjoin
