// SPDX-License-Identifier: BSD-3-Clause
// SparseCholesky by SuiteSparse CHOLMOD, on one thread: parallelism is ours, over maps and subtrees.
#ifdef MAPJOIN_CHOLMOD
#include <cholmod.h>
#include <dlfcn.h>

#include <mapjoin/solve/pivot.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>
#include <new>
#include <stdexcept>

namespace mapjoin {
namespace {

/// A function of the libraries that CHOLMOD brought along, or null where there is none of that name.
template <typename Function>
Function* loaded_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

/// Nested OpenMP and BLAS threads made CHOLMOD slower, and would make its sums depend on their number.
void use_one_blas_thread() {
  if (auto* set_threads = loaded_function<void(int)>("openblas_set_num_threads")) set_threads(1);
}

/// While it lives, the calling thread opens no parallel region of OpenMP. (The limit belongs to each thread.)
class NoOpenMp {
 public:
  NoOpenMp() : before_(get_levels ? get_levels() : 0) {
    if (set_levels) set_levels(0);
  }
  ~NoOpenMp() {
    if (set_levels) set_levels(before_);
  }
  NoOpenMp(const NoOpenMp&) = delete;
  NoOpenMp& operator=(const NoOpenMp&) = delete;

 private:
  static inline auto* const get_levels = loaded_function<int()>("omp_get_max_active_levels");
  static inline auto* const set_levels = loaded_function<void(int)>("omp_set_max_active_levels");
  int before_;
};

cholmod_sparse view(const SparseLower& matrix) {
  cholmod_sparse A{};
  A.nrow = A.ncol = static_cast<std::size_t>(matrix.size());
  A.nzmax = matrix.rows.size();
  A.p = const_cast<std::int64_t*>(matrix.column_begin.data());
  A.i = const_cast<std::int64_t*>(matrix.rows.data());
  A.x = const_cast<double*>(matrix.values.data());
  A.stype = -1;
  A.itype = CHOLMOD_LONG;
  A.xtype = CHOLMOD_REAL;
  A.dtype = CHOLMOD_DOUBLE;
  A.sorted = 1;
  A.packed = 1;
  return A;
}

/// L_jj of every column j, in the order of the factor.
Eigen::VectorXd factor_diagonal(const cholmod_factor& L) {
  Eigen::VectorXd diagonal(static_cast<Eigen::Index>(L.n));
  const auto* x = static_cast<const double*>(L.x);
  if (!L.is_super) {
    const auto* p = static_cast<const std::int64_t*>(L.p);
    for (Eigen::Index j = 0; j < diagonal.size(); ++j) diagonal[j] = x[p[j]];
    return diagonal;
  }
  const auto* super = static_cast<const std::int64_t*>(L.super);
  const auto* pi = static_cast<const std::int64_t*>(L.pi);
  const auto* px = static_cast<const std::int64_t*>(L.px);
  for (std::size_t s = 0; s < L.nsuper; ++s) {
    const std::int64_t rows = pi[s + 1] - pi[s];
    for (std::int64_t j = super[s]; j < super[s + 1]; ++j) diagonal[j] = x[px[s] + (j - super[s]) * (rows + 1)];
  }
  return diagonal;
}

Supernodes supernodes_of(const cholmod_factor& L) {
  const auto* super = static_cast<const std::int64_t*>(L.super);
  const auto* pi = static_cast<const std::int64_t*>(L.pi);
  const auto* px = static_cast<const std::int64_t*>(L.px);
  const auto* rows = static_cast<const std::int64_t*>(L.s);
  const auto* x = static_cast<const double*>(L.x);
  Supernodes nodes;
  for (std::size_t s = 0; s < L.nsuper; ++s) {
    nodes.push_back({super[s], super[s + 1], {rows + pi[s], rows + pi[s + 1]}, x + px[s]});
  }
  return nodes;
}

Supernodes columns_of(const cholmod_factor& L) {
  const auto* p = static_cast<const std::int64_t*>(L.p);
  const auto* nz = static_cast<const std::int64_t*>(L.nz);
  const auto* rows = static_cast<const std::int64_t*>(L.i);
  const auto* x = static_cast<const double*>(L.x);
  Supernodes nodes;
  for (std::int64_t j = 0; j < static_cast<std::int64_t>(L.n); ++j) {
    nodes.push_back({j, j + 1, {rows + p[j], static_cast<std::size_t>(nz[j])}, x + p[j]});
  }
  return nodes;
}

}  // namespace

struct SparseCholesky::Factor {
  cholmod_common common;
  cholmod_factor* L = nullptr;

  Factor() {
    static const bool once = (use_one_blas_thread(), true);
    static_cast<void>(once);
    cholmod_l_start(&common);
    common.print = 0;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_NATURAL;
    common.postorder = 0;
    common.final_ll = 1;
    common.quick_return_if_not_posdef = 1;
  }
  ~Factor() {
    cholmod_l_free_factor(&L, &common);
    cholmod_l_finish(&common);
  }
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;

  void check() const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
    if (common.status < CHOLMOD_OK) throw std::runtime_error("CHOLMOD failed with status " + std::to_string(common.status));
  }
};

SparseCholesky::SparseCholesky() = default;
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyse(const SparseLower& matrix) {
  const NoOpenMp serial;
  factor_ = std::make_unique<Factor>();
  cholmod_sparse A = view(matrix);
  factor_->L = cholmod_l_analyze(&A, &factor_->common);
  factor_->check();
}

std::optional<std::int64_t> SparseCholesky::factorise(const SparseLower& matrix) {
  const NoOpenMp serial;
  cholmod_sparse A = view(matrix);
  cholmod_l_factorize(&A, factor_->L, &factor_->common);
  factor_->check();
  const cholmod_factor& L = *factor_->L;
  if (L.minor < L.n) return static_cast<std::int64_t>(L.minor);

  const Eigen::VectorXd pivots = factor_diagonal(L);
  for (std::int64_t j = 0; j < pivots.size(); ++j) {
    std::int64_t p = matrix.column_begin[static_cast<std::size_t>(j)];
    while (matrix.rows[static_cast<std::size_t>(p)] != j) ++p;
    if (has_lost_digits(pivots[j], matrix.values[static_cast<std::size_t>(p)])) return j;
  }
  return std::nullopt;
}

Eigen::MatrixXd SparseCholesky::solve_columns(const Eigen::MatrixXd& B) const {
  const NoOpenMp serial;
  cholmod_dense rhs{};
  rhs.nrow = rhs.d = static_cast<std::size_t>(B.rows());
  rhs.ncol = static_cast<std::size_t>(B.cols());
  rhs.nzmax = rhs.nrow * rhs.ncol;
  rhs.x = const_cast<double*>(B.data());
  rhs.xtype = CHOLMOD_REAL;
  rhs.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod_l_solve(CHOLMOD_A, factor_->L, &rhs, &factor_->common);
  factor_->check();
  const Eigen::MatrixXd solution = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(x->x), B.rows(), B.cols());
  cholmod_l_free_dense(&x, &factor_->common);
  return solution;
}

Supernodes SparseCholesky::supernodes() const {
  const cholmod_factor& L = *factor_->L;
  return L.is_super ? supernodes_of(L) : columns_of(L);
}

std::string blas_name() {
  auto* config = loaded_function<char*()>("openblas_get_config");
  return config ? config() : "BLAS of the system";
}

}  // namespace mapjoin
#endif
