// SPDX-License-Identifier: BSD-3-Clause
// SparseCholesky by Eigen's SimplicialLLT, for builds without CHOLMOD.
#ifndef MAPJOIN_CHOLMOD
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <mapjoin/solve/pivot.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>

namespace mapjoin {
namespace {

using EigenSparse = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t>;

EigenSparse copy(const SparseLower& matrix) {
  return Eigen::Map<const EigenSparse>(matrix.size(), matrix.size(), static_cast<Eigen::Index>(matrix.rows.size()),
                                       matrix.column_begin.data(), matrix.rows.data(), matrix.values.data());
}

/// Eigen's factorisation ends at the first pivot that is not positive, and does not say which: the pivots it did not come to
/// are zero here.
struct Llt : Eigen::SimplicialLLT<EigenSparse, Eigen::Lower, Eigen::NaturalOrdering<std::int64_t>> {
  void factorise(const EigenSparse& A) {
    std::fill_n(m_matrix.valuePtr(), m_matrix.nonZeros(), 0.0);
    factorize(A);
  }
  /// Each column begins with its pivot.
  double pivot(Eigen::Index j) const { return m_matrix.valuePtr()[m_matrix.outerIndexPtr()[j]]; }
};

}  // namespace

struct SparseCholesky::Factor {
  Llt llt;
};

SparseCholesky::SparseCholesky() = default;
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyse(const SparseLower& matrix) {
  factor_ = std::make_unique<Factor>();
  factor_->llt.analyzePattern(copy(matrix));
}

std::optional<std::int64_t> SparseCholesky::factorise(const SparseLower& matrix) {
  const EigenSparse A = copy(matrix);
  factor_->llt.factorise(A);
  const Eigen::VectorXd diagonal = A.diagonal();
  for (Eigen::Index j = 0; j < diagonal.size(); ++j) {
    if (has_lost_digits(factor_->llt.pivot(j), diagonal[j])) return j;
  }
  return std::nullopt;
}

Eigen::MatrixXd SparseCholesky::solve_columns(const Eigen::MatrixXd& B) const {
  return factor_->llt.solve(B);
}

Supernodes SparseCholesky::supernodes() const {
  const EigenSparse& L = factor_->llt.matrixL().nestedExpression();
  Supernodes factor;
  for (std::int64_t j = 0; j < L.cols(); ++j) {
    const std::int64_t begin = L.outerIndexPtr()[j];
    const auto height = static_cast<std::size_t>(L.outerIndexPtr()[j + 1] - begin);
    factor.push_back({j, j + 1, {L.innerIndexPtr() + begin, height}, L.valuePtr() + begin});
  }
  return factor;
}

std::string blas_name() {
  return "none (Eigen)";
}

}  // namespace mapjoin
#endif
